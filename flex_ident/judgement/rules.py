"""The rules of the verdicts, each an object by itself: a code, what it makes of a result, and when it speaks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from flex_ident.judgement.evidence import Cause, Evidence, FitEvidence, LinearEvidence
from flex_ident.judgement.thresholds import (
    CERTAIN_GAIN,
    DRIFT_STDS,
    DRIFTED,
    HOPELESS_PERCENT,
    LATE_STDS,
    MOVED,
    POOR_PERCENT,
    SAMPLES_A_PERIOD,
    SCALE_GAIN,
    UNSEEN_PERCENT,
    UNSEEN_RATIO,
    WEAK_PERCENT,
    X5_DOUBTFUL,
    X5_REJECTED,
)
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Parameter, Verdict

E = TypeVar("E", bound=Evidence)
ESSENTIAL = ("Jm", "K", "JL", "J")
"""Parameters without which a result says nothing of a joint."""
FRICTION_FIRST = ("FV", "FS", "MX", "MY")
"""What a slow recording of a rigid joint answers, inertia or not."""
SIGNALS = {"torque_delay": Code.TORQUE_DELAY, "link_skew": Code.LINK_SKEW}
ORDER: tuple[Verdict, ...] = ("rejected", "doubtful", "trusted")


@dataclass(frozen=True)
class Rule(Generic[E]):
    """What makes a result no better than `verdict`, with a notice of `code` for each reason; `trusted`: only said."""

    code: Code
    verdict: Verdict
    reasons: Callable[[E], Iterable[Notice]]


def judged(evidence: E, rules: Sequence[Rule[E]]) -> tuple[Verdict, tuple[Notice, ...]]:
    """The verdict, and a notice for each reason that some rule has: those that reject first."""
    found: dict[Verdict, list[Notice]] = {verdict: [] for verdict in ORDER}
    for rule in rules:
        found[rule.verdict].extend(rule.reasons(evidence))
    worst: Verdict = next((verdict for verdict in ORDER if found[verdict]), "trusted")
    return worst, tuple(notice for verdict in ORDER for notice in found[verdict])


def known_only(p: Parameter) -> Notice:
    """That a parameter is known poorly."""
    return Notice(Code.LOW_EXCITATION, p.key, {"relative_std_percent": p.relative_std_percent})


def not_determined(p: Parameter) -> Notice:
    """That the data do not determine a parameter, and how far they do."""
    return Notice(Code.NOT_IDENTIFIABLE, p.key, {"value": p.value, "std": p.std}, {"unit": p.unit})


def _needed(evidence: Evidence) -> tuple[str, ...]:
    """Parameters without which nothing is answered: not the inertia of a rigid joint whose friction or weight shows."""
    shown = any(p.identifiable and p.key in FRICTION_FIRST for p in evidence.parameters)
    return tuple(k for k in ESSENTIAL if not (k == "J" and shown))


def _essential(evidence: Evidence) -> Iterator[Notice]:
    needed = _needed(evidence)
    yield from (not_determined(p) for p in evidence.parameters if p.key in needed and not p.identifiable)


def _others(evidence: Evidence) -> Iterator[Notice]:
    needed = _needed(evidence)
    yield from (not_determined(p) for p in evidence.parameters if p.key not in needed and not p.identifiable)


def _weak(evidence: Evidence) -> Iterator[Notice]:
    for p in evidence.parameters:
        if p.key in ESSENTIAL and p.identifiable and p.relative_std_percent > WEAK_PERCENT:
            yield known_only(p)


def _worst_percent(evidence: Evidence) -> float:
    error, unseen = evidence.error_percent, evidence.validation_percent
    return max(error, unseen if math.isfinite(unseen) else error)


def _mismatch(evidence: Evidence) -> Notice:
    return Notice(Code.MODEL_MISMATCH, numbers={"left_percent": _worst_percent(evidence)})


def _poor(evidence: Evidence) -> Iterator[Notice]:
    if POOR_PERCENT < _worst_percent(evidence) <= HOPELESS_PERCENT:
        yield _mismatch(evidence)


def _poor_beyond_noise(evidence: FitEvidence) -> Iterator[Notice]:
    """Much that is left is no mismatch where it is noise."""
    if evidence.structured or not evidence.noise_known:
        yield from _poor(evidence)


def _hopeless(evidence: Evidence) -> Iterator[Notice]:
    if not _worst_percent(evidence) <= HOPELESS_PERCENT:
        yield _mismatch(evidence)


def _late(evidence: Evidence) -> Iterator[Notice]:
    for p in evidence.measurement:
        if p.key in SIGNALS and abs(p.value) > evidence.sample_time + LATE_STDS * p.std:
            sizes = {"delay_s": p.value, "std": p.std, "sample_s": evidence.sample_time}
            yield Notice(SIGNALS[p.key], p.key, sizes)


def _lagging(evidence: FitEvidence) -> Iterator[Notice]:
    for p in evidence.measurement:
        if p.key == "effort_lag" and p.value > evidence.sample_time + LATE_STDS * p.std:
            yield Notice(Code.EFFORT_LAG, "motor_torque", {"lag_ms": 1e3 * p.value, "std_ms": 1e3 * p.std})


def _drifting(evidence: FitEvidence) -> Iterator[Notice]:
    for p in evidence.measurement:
        total = p.value * evidence.seconds
        if p.key == "link_drift" and abs(p.value) > DRIFT_STDS * p.std and abs(total) > DRIFTED * evidence.sample_time:
            sizes = {"ppm": 1e6 * p.value, "std_ppm": 1e6 * p.std, "total_ms": 1e3 * total}
            yield Notice(Code.CLOCK_DRIFT, "link_position", sizes, {"case": "fitted"})


def _nothing_unseen(evidence: FitEvidence) -> Iterator[Notice]:
    if not math.isfinite(evidence.validation_percent):
        yield Notice(Code.VALIDATION_GAP, texts={"case": "short"})


def _worse_unseen(evidence: FitEvidence) -> Iterator[Notice]:
    error, unseen = evidence.error_percent, evidence.validation_percent
    if math.isfinite(unseen) and unseen > UNSEEN_RATIO * error + UNSEEN_PERCENT:
        errors = {"unseen_percent": unseen, "error_percent": error}
        yield Notice(Code.VALIDATION_GAP, numbers=errors, texts={"case": "larger"})


def _mode_outside(evidence: FitEvidence) -> Iterator[Notice]:
    if evidence.locked_motor_hz > evidence.band_hz:
        found = {"locked_motor_hz": evidence.locked_motor_hz, "band_hz": evidence.band_hz}
        yield Notice(Code.MODE_OUTSIDE_BAND, numbers=found)


def _sampled_slowly(evidence: FitEvidence) -> Iterator[Notice]:
    rate_hz, locked = 1.0 / evidence.sample_time, evidence.locked_motor_hz
    if rate_hz < SAMPLES_A_PERIOD * locked:
        wanted = math.ceil(SAMPLES_A_PERIOD * locked)
        found = {"rate_hz": rate_hz, "locked_motor_hz": locked, "wanted_hz": wanted}
        yield Notice(Code.SAMPLED_SLOWLY, numbers=found)


def _noise_unknown(evidence: FitEvidence) -> Iterator[Notice]:
    if not evidence.noise_known:
        yield Notice(Code.NOISE_UNKNOWN, "motor_torque", {"left": evidence.gap})


def _structure(evidence: FitEvidence) -> Iterator[Notice]:
    if evidence.structured:
        sizes = {"gap": evidence.gap, "noise": evidence.noise}
        texts = {"unit": "N m", "case": "throughout"}
        if evidence.burst is not None:
            sizes["from_s"], sizes["to_s"] = evidence.burst
            texts["case"] = "burst"
        yield Notice(Code.STRUCTURED_RESIDUAL, "motor_torque", sizes, texts)


def _link_structure(evidence: FitEvidence) -> Iterator[Notice]:
    if evidence.link is not None:
        gap, noise = evidence.link
        yield Notice(Code.STRUCTURED_LINK, "link_position", {"gap": gap, "noise": noise}, {"unit": "rad"})


def _other_joints(evidence: FitEvidence) -> Iterator[Notice]:
    if evidence.other_joints is not None:
        other = evidence.other_joints
        sizes = {"share_percent": 100.0 * other.share, "chance": other.chance}
        yield Notice(Code.OTHER_JOINTS_EXPLAIN, "motor_torque", sizes, {"joints": ", ".join(other.joints)})


def _certain(cause: Cause) -> float:
    """The gain from which a cause counts that leaves no gap."""
    return SCALE_GAIN if cause.scales_torque else CERTAIN_GAIN


def _cause(evidence: FitEvidence) -> Iterator[Notice]:
    """The likeliest cause of structure; without structure, the one that would move the parameters most."""
    strong = [c for c in evidence.causes if c.strong]
    if not evidence.structured:
        strong = sorted(strong, key=lambda c: -c.moved_stds)
        strong = [c for c in strong if c.moved_stds > MOVED and c.gain > _certain(c)]
    for first in strong[:1]:
        sizes = {"moved_stds": first.moved_stds, "gain": first.gain}
        yield Notice(Code.CAUSE_SUSPECTED, first.effect, sizes)


def _strained(evidence: FitEvidence) -> Iterator[Notice]:
    known = {p.key: p for p in evidence.measurement}
    for key in evidence.strained:
        value = known[key].value if key in known else math.nan
        yield Notice(Code.CHAIN_AT_ITS_END, key, {"value": value})


def _apart(evidence: FitEvidence) -> Iterator[Notice]:
    if evidence.other_end is not None:
        key, *ends = evidence.other_end
        yield Notice(Code.STARTS_DISAGREE, key, {"lowest": min(ends), "highest": max(ends)})


def _opposed(evidence: LinearEvidence) -> Iterator[Notice]:
    if evidence.opposed:
        yield Notice(Code.EFFORT_REVERSED, "motor_torque")


def _impossible(evidence: LinearEvidence) -> Iterator[Notice]:
    if not evidence.possible and not evidence.opposed:
        yield Notice(Code.NOT_PHYSICAL)


def _groups(evidence: LinearEvidence, *, essential: bool) -> Iterator[Notice]:
    for group in evidence.undetermined:
        if bool(set(group) & set(ESSENTIAL)) == essential:
            yield Notice(Code.UNDETERMINED, ", ".join(group), texts={"case": "linear"})


def _x5(evidence: LinearEvidence, low: float, high: float) -> Iterator[Notice]:
    if evidence.x5_stds is not None and low < evidence.x5_stds <= high:
        yield Notice(Code.X5_INCONSISTENT, "X5", {"sigmas": evidence.x5_stds})


def _simplified(evidence: LinearEvidence) -> Iterator[Notice]:
    if evidence.x5_stds is not None and not evidence.x5_stds > X5_DOUBTFUL:
        yield Notice(Code.SIMPLIFIED_MODEL)


def _low_rate(evidence: LinearEvidence) -> Iterator[Notice]:
    rate_hz = 1.0 / evidence.sample_time
    if evidence.required_rate_hz > rate_hz:
        rates = {"rate_hz": rate_hz, "required_hz": evidence.required_rate_hz}
        yield Notice(Code.LOW_SAMPLING_RATE, numbers=rates)


FIT_RULES: tuple[Rule[FitEvidence], ...] = (
    Rule(Code.NOT_IDENTIFIABLE, "rejected", _essential),
    Rule(Code.LOW_EXCITATION, "doubtful", _weak),
    Rule(Code.VALIDATION_GAP, "rejected", _nothing_unseen),
    Rule(Code.MODEL_MISMATCH, "rejected", _hopeless),
    Rule(Code.MODEL_MISMATCH, "doubtful", _poor_beyond_noise),
    Rule(Code.VALIDATION_GAP, "doubtful", _worse_unseen),
    Rule(Code.MODE_OUTSIDE_BAND, "doubtful", _mode_outside),
    Rule(Code.SAMPLED_SLOWLY, "doubtful", _sampled_slowly),
    Rule(Code.NOISE_UNKNOWN, "doubtful", _noise_unknown),
    Rule(Code.STRUCTURED_RESIDUAL, "doubtful", _structure),
    Rule(Code.STRUCTURED_LINK, "doubtful", _link_structure),
    Rule(Code.OTHER_JOINTS_EXPLAIN, "doubtful", _other_joints),
    Rule(Code.CAUSE_SUSPECTED, "doubtful", _cause),
    Rule(Code.CHAIN_AT_ITS_END, "doubtful", _strained),
    Rule(Code.STARTS_DISAGREE, "doubtful", _apart),
    Rule(Code.TORQUE_DELAY, "doubtful", _late),
    Rule(Code.EFFORT_LAG, "trusted", _lagging),
    Rule(Code.CLOCK_DRIFT, "trusted", _drifting),
    Rule(Code.NOT_IDENTIFIABLE, "trusted", _others),
)
LINEAR_RULES: tuple[Rule[LinearEvidence], ...] = (
    Rule(Code.EFFORT_REVERSED, "rejected", _opposed),
    Rule(Code.NOT_PHYSICAL, "rejected", _impossible),
    Rule(Code.UNDETERMINED, "rejected", lambda e: _groups(e, essential=True)),
    Rule(Code.UNDETERMINED, "trusted", lambda e: _groups(e, essential=False)),
    Rule(Code.NOT_IDENTIFIABLE, "rejected", _essential),
    Rule(Code.NOT_IDENTIFIABLE, "trusted", _others),
    Rule(Code.LOW_EXCITATION, "doubtful", _weak),
    Rule(Code.MODEL_MISMATCH, "rejected", _hopeless),
    Rule(Code.MODEL_MISMATCH, "doubtful", _poor),
    Rule(Code.X5_INCONSISTENT, "rejected", lambda e: _x5(e, X5_REJECTED, math.inf)),
    Rule(Code.X5_INCONSISTENT, "doubtful", lambda e: _x5(e, X5_DOUBTFUL, X5_REJECTED)),
    Rule(Code.SIMPLIFIED_MODEL, "doubtful", _simplified),
    Rule(Code.LOW_SAMPLING_RATE, "doubtful", _low_rate),
    Rule(Code.TORQUE_DELAY, "doubtful", _late),
)
