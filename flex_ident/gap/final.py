"""The final model: accepted effects judged again in it, and the gap after each step on data not fitted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flex_ident.effects import effect_named
from flex_ident.estimation.base_fit import settled
from flex_ident.estimation.estimate import Estimate, estimate_of, validation_blocks
from flex_ident.gap.base import polished
from flex_ident.gap.explanation import Rejected
from flex_ident.gap.found import Search
from flex_ident.gap.options import GapOptions
from flex_ident.gap.sizes import GapSize, gap_size
from flex_ident.gap.thresholds import SIGNIFICANT, SIGNIFICANT_STATED, SMALLEST_SHARE
from flex_ident.gap.weighing import rebuilt
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Reason, Why
from flex_ident.parameters.keys import key_text
from flex_ident.parameters.parameter import FAR_MODE
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import Candidate

VALIDATION_ITERATIONS = 5


def judged_again(
    search: Search, searching: SteadyFit, start: Fit, base: tuple[SteadyFit, Fit], problem: FitProblem,
    options: GapOptions,
) -> tuple[Search, list[GapSize], Estimate]:  # fmt: skip
    """The search with what holds in the final model only, the gap after each step, and the final model.

    Each accepted effect must lower the gap on data not fitted, of the torque or of the link's position, be significant
    in the final model, and be no larger than it can be. One that fails goes, and the rest is fitted again.
    """
    held = validation_blocks(problem)
    while True:
        estimate = _final_estimate(search, base, problem, options)
        middle = [(a.trial.solver, search.after(i)) for i, a in enumerate(search.accepted[:-1])]
        gaps = [gap_size(problem, trained_values(s, f, problem, held), held) for s, f in (base, *middle)]
        if search.accepted:
            gaps.append(gap_size(problem, estimate.trained, held))
        failed = next(
            ((a, why) for i, a in reversed(list(enumerate(search.accepted))) if not a.by_hand
             and (why := _fails(a.trial.candidate, gaps[i], gaps[i + 1], estimate))), None,
        )  # fmt: skip
        if failed is None:
            return search, gaps, estimate
        accepted, why = failed
        search.rejected[accepted.trial.effect] = Rejected(accepted.trial.effect, max(0.0, accepted.trial.share), why)
        kept = [a for a in search.accepted if a is not accepted]
        search = rebuilt(search, kept, searching, start)


def _fails(candidate: Candidate, before: GapSize, after: GapSize, estimate: Estimate) -> Reason | None:
    """Why an accepted effect does not hold in the final model; None where it does."""
    if not after.falls_from(before):
        return Reason(Why.GAP_DOES_NOT_FALL, numbers={**before.numbers("before"), **after.numbers("after")})
    closed = 1.0 - (after.torque / before.torque) ** 2
    closable = 1.0 - (estimate.left.floor / before.torque) ** 2
    if before.link is not None and before.of_link is None and not closed > SMALLEST_SHARE * closable:
        return Reason(Why.LINK_ALONE, numbers={"link_mrad": 1e3 * before.link})
    if estimate.left.evidence == "none" and not closed > SMALLEST_SHARE and after.link is None:
        shares = {"percent": 100.0 * closed, "needed_percent": 100.0 * SMALLEST_SHARE}
        return Reason(Why.NOISE_UNKNOWN, numbers=shares)
    ratios = {k: abs(estimate.fit.values[k]) / max(estimate.plain.std(k), 1e-300) for k in candidate.scaled}
    best = max(ratios, key=lambda k: ratios[k])
    if ratios[best] < SIGNIFICANT:
        return Reason(Why.OPEN_IN_FINAL, best, {"stds": ratios[best]})
    stated = max(abs(estimate.fit.values[k]) / max(estimate.uncertainty.std(k), 1e-300) for k in candidate.scaled)
    if stated < SIGNIFICANT_STATED:
        return Reason(Why.OPEN_WITH_ALL, best, {"stds": stated})
    effect = effect_named(candidate.effect)
    for key in (key_text(effect.name, name) for name in effect.essential):
        known = abs(estimate.fit.values.get(key, 0.0)) / max(estimate.uncertainty.std(key), 1e-300)
        if key in candidate.keys and known < SIGNIFICANT_STATED:
            return Reason(Why.OPEN_WITH_ALL, key, {"stds": known})
    if effect.reach is not None:
        there = estimate.fit.values.effects.get(effect.name, {})
        return effect.reach({p.name: there.get(p.name, 0.0) for p in effect.parameters}, estimate.fit.values)
    return None


def _final_estimate(search: Search, base: tuple[SteadyFit, Fit], problem: FitProblem, options: GapOptions) -> Estimate:
    """The final model, fitted as identification fits."""
    if not search.accepted:
        return estimate_of(*base, prismatic=options.prismatic)
    solver = SteadyFit(problem, priors=search.solver.priors, marks=base[0].marks, local=True)
    # Also with what the search goes without, a mode above the band.
    keys = (*search.fit.free, *(k for k in solver.priors if k == FAR_MODE and k not in search.fit.free))
    values = settled(problem, search.fit.values, solver.priors)
    return estimate_of(solver, polished(solver, keys, values), prismatic=options.prismatic)


def trained_values(solver: SteadyFit, fit: Fit, problem: FitProblem, held: NDArray[np.bool_]) -> Values:
    """Values of the same keys, fitted without the validation part."""
    own = SteadyFit(problem.restricted(problem.usable & ~held), priors=solver.priors, marks=solver.marks)
    return own.solve(fit.free, fit.values, fit.whitenings, iterations=VALIDATION_ITERATIONS, tolerance=1e-5).values
