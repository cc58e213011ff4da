"""How far a result may be trusted, in words: what is not identifiable, why, and which experiment would help."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from flex_ident.estimation.estimate import Estimate
from flex_ident.likelihood.remainder import Remainder
from flex_ident.notices import Code, Notice
from flex_ident.parameters import UNITS, Parameter, Verdict
from flex_ident.regression.verdict import (
    ESSENTIAL,
    HOPELESS_PERCENT,
    WEAK_PERCENT,
    known_only,
    late_signals,
    mismatches,
    not_determined,
)
from flex_ident.screening.coupling import Coupling
from flex_ident.screening.suspects import Suspect

RELATIVE_LIMIT = 0.3
"""A parameter less certain than this, relative to itself, is identifiable only if small in effect."""
EFFECT_LIMIT = 0.01
"""Share of the torque's rms that an uncertainty may move for a parameter near zero to count as known."""

SAMPLES_A_PERIOD = 10.0
"""Samples in a period of the locked-motor frequency under which a result is doubtful."""

CERTAIN_GAIN = 300.0
"""Gain of an effect that leaves no gap from which it counts: jitter of the clock made up to 210 in the link channel of
the virtual paper joint, and 130 in `bench/coverage.py`, seed 1."""
MOVED = 5.0
"""Standard deviations by which an effect that the recording shows must move a parameter to make the result doubtful."""

Objection = tuple[Verdict, Notice | None]


def torque_per_std(estimate: Estimate, key: str) -> float:
    """Rms of the motor torque, N m, that one standard deviation of a key moves (link channel left out)."""
    std = estimate.uncertainty.std(key)
    if not math.isfinite(std):
        return math.inf
    problem, values = estimate.problem, estimate.fit.values
    step = max(abs(values[key]), std, 1e-9) * 1e-3
    rows = problem.usable
    here = problem.prediction(values).torque[rows]
    there = problem.prediction({**values, key: values[key] + step}).torque[rows]
    return float(np.sqrt(np.mean((there - here) ** 2))) / step * std


def is_identifiable(estimate: Estimate, key: str) -> bool:
    """Whether the data determine a key: known to 30 %, or known to be too small to matter."""
    std = estimate.uncertainty.std(key)
    value = estimate.fit.values[key]
    if not math.isfinite(std):
        return False
    if std <= RELATIVE_LIMIT * abs(value):
        return True
    if key in ESSENTIAL:
        return False
    rms = float(np.sqrt(np.mean(estimate.problem.torque[estimate.problem.usable] ** 2)))
    return torque_per_std(estimate, key) <= EFFECT_LIMIT * rms


def identifiability_notices(parameters: tuple[Parameter, ...]) -> list[Notice]:
    """One notice a parameter that the data cannot determine, with the experiment that would."""
    return [not_determined(p) for p in parameters if not p.identifiable]


@dataclass(frozen=True)
class Evidence:
    """What a verdict is made of: errors in percent of the torque, modes and band in Hz, delays and period in s."""

    parameters: tuple[Parameter, ...]
    error_percent: float
    validation_percent: float
    measurement: tuple[Parameter, ...]
    sample_time: float
    locked_motor_hz: float
    band_hz: float
    left: Remainder
    suspects: tuple[Suspect, ...] = ()
    moved: Mapping[str, float] = field(default_factory=dict)
    """For each suspect the most standard deviations by which it would move a parameter that the data determine."""
    coupling: Coupling | None = None
    strained: tuple[str, ...] = ()


def moved_stds(estimate: Estimate) -> dict[str, float]:
    """For each suspect the most standard deviations by which it would move a base parameter, were the model right."""
    fit, plain = estimate.fit, estimate.plain
    found: dict[str, float] = {}
    for suspect in estimate.suspects:
        sizes = [
            abs(float(suspect.shift[i])) / plain.std(key)
            for i, key in enumerate(fit.free)
            if key in UNITS and 0.0 < plain.std(key) < math.inf and is_identifiable(estimate, key)
        ]
        found[suspect.effect] = max(found.get(suspect.effect, 0.0), *sizes, 0.0)
    return found


def judged(evidence: Evidence) -> tuple[Verdict, list[Notice]]:
    """The verdict, with a notice for each thing that spoke against a better one."""
    objections = [
        *_weak_parameters(evidence),
        *_poor_reproduction(evidence),
        *_mode_outside_band(evidence),
        *_sampled_slowly(evidence),
        *_structure(evidence),
        *_strained_chain(evidence),
        *(("doubtful", notice) for notice in late_signals(evidence.measurement, evidence.sample_time)),
    ]
    worst: Verdict = "trusted"
    for verdict, _ in objections:
        if verdict == "rejected" or worst == "trusted":
            worst = verdict
    return worst, [notice for _, notice in objections if notice is not None]


def _weak_parameters(evidence: Evidence) -> Iterator[Objection]:
    for p in evidence.parameters:
        if p.key not in ESSENTIAL:
            continue
        if not p.identifiable:
            yield "rejected", None  # identifiability_notices says it
        elif p.relative_std_percent > WEAK_PERCENT:
            yield "doubtful", known_only(p)


def _poor_reproduction(evidence: Evidence) -> Iterator[Objection]:
    error, unseen = evidence.error_percent, evidence.validation_percent
    if not math.isfinite(unseen):
        yield "rejected", Notice(Code.VALIDATION_GAP, texts={"case": "short"})
        unseen = error
    worst = max(error, unseen)
    for notice in mismatches(worst):
        yield "doubtful" if worst <= HOPELESS_PERCENT else "rejected", notice
    if unseen > 1.5 * error + 2.0:
        errors = {"unseen_percent": unseen, "error_percent": error}
        yield "doubtful", Notice(Code.VALIDATION_GAP, numbers=errors, texts={"case": "larger"})


def _mode_outside_band(evidence: Evidence) -> Iterator[Objection]:
    if evidence.locked_motor_hz > evidence.band_hz:
        found = {"locked_motor_hz": evidence.locked_motor_hz, "band_hz": evidence.band_hz}
        yield "doubtful", Notice(Code.MODE_OUTSIDE_BAND, numbers=found)


def _sampled_slowly(evidence: Evidence) -> Iterator[Objection]:
    rate_hz, wanted_hz = 1.0 / evidence.sample_time, SAMPLES_A_PERIOD * evidence.locked_motor_hz
    if rate_hz < wanted_hz:
        locked, wanted = evidence.locked_motor_hz, math.ceil(wanted_hz)
        found = {"rate_hz": rate_hz, "locked_motor_hz": locked, "wanted_hz": wanted}
        yield "doubtful", Notice(Code.SAMPLED_SLOWLY, numbers=found)


def _structure(evidence: Evidence) -> Iterator[Objection]:
    """More is left than noise, or an effect is seen that would move the parameters."""
    left = evidence.left
    if left.evidence == "none":
        yield "doubtful", Notice(Code.NOISE_UNKNOWN, "motor_torque", {"left": left.gap})
    structured = left.structured(left.gap)
    if structured:
        sizes = {"gap": left.gap, "noise": left.floor}
        yield "doubtful", Notice(Code.STRUCTURED_RESIDUAL, "motor_torque", sizes, {"unit": "N m"})
    if evidence.coupling is not None and evidence.coupling.seen:
        yield "doubtful", coupling_notice(evidence.coupling)
    strong = [s for s in evidence.suspects if s.strong]
    if not structured:  # what does not show as a gap matters only by what it moves
        strong = sorted(strong, key=lambda s: -evidence.moved.get(s.effect, 0.0))
        strong = [s for s in strong if evidence.moved.get(s.effect, 0.0) > MOVED and s.gain > CERTAIN_GAIN]
    if strong:
        found = {"moved_stds": evidence.moved.get(strong[0].effect, 0.0), "gain": strong[0].gain}
        yield "doubtful", Notice(Code.CAUSE_SUSPECTED, strong[0].effect, found)


def _strained_chain(evidence: Evidence) -> Iterator[Objection]:
    """What the measurement chain is estimated to be is more than a chain can be: it stands in for something else."""
    known = {p.key: p for p in evidence.measurement}
    for key in evidence.strained:
        value = known[key].value if key in known else math.nan
        yield "doubtful", Notice(Code.CHAIN_AT_ITS_END, key, {"value": value})


def coupling_notice(coupling: Coupling) -> Notice:
    """That the other joints' motion explains part of what a model leaves."""
    sizes = {"share_percent": 100.0 * coupling.share, "chance": coupling.chance}
    return Notice(Code.OTHER_JOINTS_EXPLAIN, "motor_torque", sizes, {"joints": ", ".join(coupling.joints)})
