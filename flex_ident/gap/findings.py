"""An accepted effect as it is told: its parameters in the final model, its evidence, and what else was considered."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flex_ident.effects import effect_named
from flex_ident.estimation.estimate import Estimate
from flex_ident.estimation.identified import identified_parameter
from flex_ident.gap.explanation import Alternative, Finding
from flex_ident.gap.found import Accepted, Search
from flex_ident.gap.measured import measured_curve
from flex_ident.gap.reading import read
from flex_ident.gap.sizes import GapSize, gap_size
from flex_ident.gap.thresholds import PERIODS
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.keys import key_parts


def finding_of(search: Search, index: int, gaps: Sequence[GapSize], estimate: Estimate) -> Finding:
    accepted = search.accepted[index]
    trial, problem, held = accepted.trial, estimate.problem, estimate.validation
    found = []
    for key in trial.candidate.keys:
        p = identified_parameter(estimate, key)
        found.append(replace(p, key=key_parts(key)[1]))
    others = tuple(
        Alternative(t.effect, gap_size(problem, t.fit.values, held).torque)
        for t in accepted.others if t.effect != trial.effect
    )[:3]  # fmt: skip
    effect = effect_named(trial.effect)
    curve = measured_curve(estimate, trial.effect)
    return Finding(
        effect=trial.effect,
        verdict="by_hand" if accepted.by_hand else "accepted",
        confidence=_confidence(accepted),
        gap_before=gaps[index].torque,
        gap_after=gaps[index + 1].torque,
        parameters=tuple(found),
        evidence=_evidence(trial.effect, accepted, gaps[index], gaps[index + 1]) + _periods_seen(accepted, problem),
        also_considered=others,
        indistinguishable_from=accepted.ties,
        experiment=effect.separated_by if accepted.ties else "",
        curve=curve,
        reading="" if curve is None else read(curve),
    )


def _confidence(accepted: Accepted) -> float:
    """Probability of this effect among all that were tried, none included, by their BIC; never quite certain."""
    best = accepted.trial.evidence
    rivals = [0.0, *(t.evidence for t in accepted.others if t.effect != accepted.trial.effect)]
    odds = sum(math.exp(min(0.0, 0.5 * (r - best))) for r in rivals)
    return min(0.99, 1.0 / (1.0 + odds))


def _evidence(name: str, accepted: Accepted, before: GapSize, after: GapSize) -> str:
    effect = effect_named(name)
    trial = accepted.trial
    text = (
        f"{effect.summary}: on data not fitted {_fall(before, after)} N m; blocks of 0.25 s "
        f"left out of the fit are predicted better by {100 * trial.held_out.share:.0f} % (t = {trial.held_out.t:.1f}), "
        f"the BIC falls by {trial.evidence:.0f}; {100 * max(0.0, min(1.0, trial.share)):.0f} % of the closable gap"
    )
    if trial.objection:
        text += f"; against it: {trial.objection}"
    return text + "."


def _fall(before: GapSize, after: GapSize) -> str:
    """Which gap falls, from what to what: the link's where it falls by more, relative to what it was."""
    torque = f"from {before.torque:.3g} to {after.torque:.3g}"
    if before.link is None or after.link is None or after.link * before.torque >= after.torque * before.link:
        return f"the gap falls {torque}"
    link = f"from {1e3 * before.link:.3g} to {1e3 * after.link:.3g} mrad"
    return f"the gap of the link's position falls {link}, that of the torque goes {torque}"


def _periods_seen(accepted: Accepted, problem: FitProblem) -> str:
    """A reservation about what is periodic in the motor's angle and was seen over little more than one period."""
    trial = accepted.trial
    cycles = trial.fit.values.get(trial.candidate.cycles)
    if cycles is None:
        return ""
    periods = cycles * float(np.ptp(problem.motion.position)) / (2.0 * math.pi)
    if periods >= PERIODS:
        return ""
    return (
        f" Only {periods:.1f} periods lie within the range of motion: it may be any torque that depends on the angle; "
        "a larger range would tell."
    )
