"""An accepted effect as it is told: its parameters in the final model, its evidence, and what else was considered."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flex_ident.effects import effect_named
from flex_ident.estimation.estimate import Estimate
from flex_ident.estimation.identified import identified_parameter
from flex_ident.gap.explanation import Alternative, Finding, Proof
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
        proof=_proof(accepted, gaps[index], gaps[index + 1], problem),
        also_considered=others,
        indistinguishable_from=accepted.ties,
        experiment=effect.separated_by if accepted.ties else "",
        curve=curve,
        reading=None if curve is None else read(curve),
    )


def _confidence(accepted: Accepted) -> float:
    """Probability of this effect among all that were tried, none included, by their BIC; never quite certain."""
    best = accepted.trial.evidence
    rivals = [0.0, *(t.evidence for t in accepted.others if t.effect != accepted.trial.effect)]
    odds = sum(math.exp(min(0.0, 0.5 * (r - best))) for r in rivals)
    return min(0.99, 1.0 / (1.0 + odds))


def _proof(accepted: Accepted, before: GapSize, after: GapSize, problem: FitProblem) -> Proof:
    trial = accepted.trial
    return Proof(
        before, after, trial.held_out.share, trial.held_out.t, trial.evidence, trial.share, trial.objection,
        _few_periods(accepted, problem),
    )  # fmt: skip


def _few_periods(accepted: Accepted, problem: FitProblem) -> float | None:
    """Periods within the range of motion of what is periodic in the motor's angle, where they are little over one."""
    trial = accepted.trial
    cycles = trial.fit.values.get(trial.candidate.cycles)
    if cycles is None:
        return None
    periods = cycles * float(np.ptp(problem.motion.position)) / (2.0 * math.pi)
    return periods if periods < PERIODS else None
