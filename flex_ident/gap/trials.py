"""A candidate refitted together with the whole model, and what speaks for and against accepting it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.effects import CATALOGUE, effect_named, parameter_named
from flex_ident.errors import ExcitationError
from flex_ident.estimation.base_fit import clearly_lower, with_nuisances_anew
from flex_ident.gap.thresholds import (
    EVIDENCE,
    HELD_OUT_T,
    LEAST_PERIODS,
    OWN_ERROR,
    SIGNIFICANT,
    SIGNIFICANT_SHAPE,
    SMALLEST_SHARE,
    WORTH_ANOTHER,
)
from flex_ident.likelihood.comparison import HeldOut, correlation_factor, held_out_comparison, log_likelihood_gain
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.remainder import coulomb, counted
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.likelihood.thresholds import OWN_ERROR_AT_REVERSALS, OWN_ERROR_OF_LINK
from flex_ident.parameters.keys import effect_in, key_text
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import Candidate
from flex_ident.screening.sketching import effects_in, extended_solver, raced

ITERATIONS = 10
ROUNDS = 6
"""Rounds of a refit that has a long way to go, the noise taken anew in each: a spring that stiffens makes its resonance
jump, and weights that expect the first residual hold it back."""


@dataclass(frozen=True)
class Trial:
    """A refit with one more effect: fall of the BIC, what left-out blocks say, share of the closable gap closed."""

    candidate: Candidate
    solver: SteadyFit
    fit: Fit
    evidence: float
    held_out: HeldOut
    share: float
    excess: float
    """What is left above the noise, relative to the noise, by energy."""
    objection: str

    @property
    def effect(self) -> str:
        """The effect's name."""
        return self.candidate.effect


def excess_of(solver: SteadyFit, fit: Fit) -> float:
    """Energy of the whitened residual above the noise, relative to it; the noise estimated from this residual."""
    residual = solver.whitened_residual(fit.values, solver.whitenings(fit.values))
    return float(residual @ residual) / residual.size - 1.0


def tried(solver: SteadyFit, fit: Fit, candidate: Candidate, starts: Sequence[Values], own_error: float) -> Trial:
    """The candidate, refitted with everything else from the best of `starts`. Raises ExcitationError.

    `own_error` is what the model without it may be wrong by itself (`own_error_of`).
    """
    extended, keys = extended_solver(solver, fit.free, candidate)
    after = _refitted(extended, keys, starts, fit)
    return compared(extended, fit, after, candidate, own_error)


def compared(solver: SteadyFit, before: Fit, after: Fit, candidate: Candidate, own_error: float) -> Trial:
    """What speaks for and against `after`, fitted by `solver`, which has the candidate, and `before`, which has not."""
    count = after.residual.size / correlation_factor(after)
    price = len(candidate.keys) * math.log(count) + 2.0 * math.log(len(CATALOGUE))
    evidence = log_likelihood_gain(before, after) - price
    held = held_out_comparison(solver.problem, before, after)
    excess, excess_before, share = closed_share(solver, before, after)
    effect = effect_named(candidate.effect)
    if effect.at_reversals:  # what a clean joint leaves there, of which the law of friction makes no less
        torque = float(np.std(solver.problem.torque[solver.problem.usable]))
        own_error = max(own_error, OWN_ERROR_AT_REVERSALS * coulomb(before.values) / torque)
    imitable = effect.imitable * own_error
    objection = _objection(solver, before, after, candidate, evidence, held, (excess_before, share), imitable)
    return Trial(candidate, solver, after, evidence, held, share, excess, objection)


def _refitted(solver: SteadyFit, keys: tuple[str, ...], starts: Sequence[Values], fit: Fit) -> Fit:
    """The fit from the best start, after a short race among several: a narrow resonance has many minima."""
    if len(starts) == 1:
        return descended(solver, keys, starts[0], fit)
    return descended(solver, keys, raced(solver, keys, starts, fit).values, fit)


def descended(solver: SteadyFit, keys: tuple[str, ...], start: Values, fit: Fit) -> Fit:
    """The fit from one start, under the noise of the fit without the candidate; on a long way with noise taken anew."""
    found = solver.solve(keys, start, fit.whitenings, iterations=ITERATIONS, tolerance=1e-4)
    for _ in range(ROUNDS):
        if found.converged:
            break
        values = found.values
        ahead = solver.solve(keys, values, solver.whitenings(values), iterations=ITERATIONS, tolerance=1e-3, rough=True)
        again = solver.solve(keys, ahead.values, fit.whitenings, iterations=ITERATIONS, tolerance=1e-4)
        done = again.cost > WORTH_ANOTHER * found.cost
        found = again if again.cost < found.cost else found
        if done:
            break
    return found


def deepened(trial: Trial, before: Fit, own_error: float) -> Trial:
    """The trial, moved on under the noise that it leaves as long as that saves much: what bends or jumps holds a fit up
    under the noise of the model without it."""
    solver, found = trial.solver, trial.fit
    for _ in range(ROUNDS):
        whitenings = solver.whitenings(found.values)
        ahead = solver.solve(found.free, found.values, whitenings, iterations=ITERATIONS, tolerance=1e-4, rough=True)
        again = solver.solve(found.free, ahead.values, before.whitenings, iterations=ITERATIONS, tolerance=1e-4)
        done = again.cost > WORTH_ANOTHER * found.cost
        found = again if again.cost < found.cost else found
        if done:
            break
    return trial if found is trial.fit else compared(solver, before, found, trial.candidate, own_error)


def without(solver: SteadyFit, fit: Fit, base: Sequence[str], kept: Sequence[Candidate]) -> Fit:
    """The model of a fit refitted with only some of its effects, on the free keys of the base."""
    reduced, keys = extended_solver(solver, base, *kept)
    values = values_with(fit.values, keys)
    return reduced.solve(keys, values, fit.whitenings, iterations=ITERATIONS, tolerance=1e-4)


def values_with(values: Values, keys: Sequence[str]) -> Values:
    """The values of the base, of the effects' `keys`, and where the points of their curves lie."""
    there = effects_in(keys)
    return values.only([k for k in values if k in keys or effect_in(k) is None or _fixed_in(k, there)])


def _fixed_in(key: str, effects: Sequence[str]) -> bool:
    return effect_in(key) in effects and parameter_named(key).fixed


def closed_share(solver: SteadyFit, before: Fit, after: Fit) -> tuple[float, float, float]:
    """Excess after and before, and share of the closable gap closed; the noise is what the refitted residual shows."""
    whitenings = solver.whitenings(after.values)
    left = solver.whitened_residual(after.values, whitenings)
    had = solver.whitened_residual(before.values, whitenings)
    excess = float(left @ left) / left.size - 1.0
    excess_before = float(had @ had) / had.size - 1.0
    if excess_before <= 0.0:
        return excess, excess_before, 0.0
    return excess, excess_before, 1.0 - max(excess, 0.0) / excess_before


def _objection(
    solver: SteadyFit, before: Fit, fit: Fit, candidate: Candidate, evidence: float, held: HeldOut,
    closable: tuple[float, float], own_error: float,
) -> str:  # fmt: skip
    """Why a candidate is not accepted; empty if nothing speaks against it. `closable`: excess before, share closed."""
    excess_before, share = closable
    if evidence < EVIDENCE:
        return (
            f"the likelihood gains too little for its parameters (BIC falls by {evidence:.0f}, {EVIDENCE:.0f} needed)"
        )
    if excess_before <= 0.0:
        return "what was left without it is no more than the noise"
    confirmed = held.share * (1.0 + excess_before) / excess_before
    needed = next((t for least, t in HELD_OUT_T if confirmed > least), math.inf)
    if held.t < needed:
        needed = min(needed, HELD_OUT_T[-1][1])
        return f"data left out of the fit do not confirm it (t = {held.t:.1f} over blocks, {needed} needed)"
    little = within_own_error(_changes(solver, before, fit), own_error)
    if little:
        return little
    rise = _torque_rms(solver, fit) / _torque_rms(solver, before) - 1.0
    if rise > 0.002:
        return f"the torque's gap grows by {100 * rise:.1f} % with it"
    bound = [k for k in candidate.keys if k in fit.at_bound and not parameter_named(k).angle]
    if bound:
        return f"{bound[0]} ends at the limit of what is physical ({fit.values[bound[0]]:.3g})"
    cycles = fit.values.get(candidate.cycles, math.inf) if effect_named(candidate.effect).whole_periods else math.inf
    if cycles * float(np.ptp(solver.problem.motion.position)) < LEAST_PERIODS * 2.0 * math.pi:
        return "it shows a part of one period only within the range of motion"
    weak = _weakest(solver, fit, candidate.scaled)
    if weak is not None:
        return f"{weak[0]} is known to {weak[1]:.1f} standard deviations only, {SIGNIFICANT:.0f} needed"
    essential = {key_text(candidate.effect, name) for name in effect_named(candidate.effect).essential}
    for key in (k for k in candidate.keys if k in essential):
        weak = _weakest(solver, fit, [key])
        if weak is not None:
            return f"without {key}, known to {weak[1]:.1f} standard deviations only, it is another effect"
    shape = [k for k in candidate.keys if k not in candidate.scaled and not parameter_named(k).angle]
    vague = _weakest(solver, fit, shape, SIGNIFICANT_SHAPE) if shape else None
    if vague is not None:
        return f"its shape is not determined: {vague[0]} is known to {vague[1]:.1f} standard deviations"
    if candidate.replaces:
        value, period = abs(fit.values[candidate.keys[0]]), solver.problem.recording.sample_time
        if value < period:
            return f"{1e3 * value:.2f} ms is less than one sample: measurement, corrected for"
    if share < SMALLEST_SHARE:
        return f"it closes {100 * share:.0f} % of the gap only, {100 * SMALLEST_SHARE:.0f} % needed for a cause"
    return ""


def within_own_error(changes: Mapping[str, float], own_error: float) -> str:
    """That an effect changes the prediction by less than the model without it may be wrong by; empty where it does not.

    `changes`: of torque and, with a link encoder, deflection, relative; `own_error`: of the torque, likewise.
    """
    errors = {"torque": own_error, "deflection": max(own_error, OWN_ERROR_OF_LINK)}
    if any(change >= errors[name] for name, change in changes.items()):
        return ""
    return "; ".join(
        f"it changes the {name} by {100 * change:.2f} % only, where the model without it may be wrong by "
        f"{100 * errors[name]:.2f} %"
        for name, change in changes.items()
    )


def own_error_of(solver: SteadyFit, accepted: Sequence[tuple[str, Fit, Fit]]) -> float:
    """Change of the prediction, relative, that method and laws may make: effects with the fits before and after."""
    laws = [
        effect_named(name).law_error * max(_changes(solver, before, after).values()) for name, before, after in accepted
    ]
    return max(OWN_ERROR, math.hypot(*laws))


def _changes(solver: SteadyFit, before: Fit, after: Fit) -> dict[str, float]:
    """By how much the predicted torque and, with a link encoder, the predicted deflection change, each relative.

    Where the motor sticks nothing counts: friction is what no model can know there.
    """
    problem, rows = solver.problem, counted(solver.problem, solver.problem.usable)
    sizes = {"torque": float(np.std(problem.torque[rows]))}
    if problem.link is not None:
        sizes["deflection"] = float(np.std((problem.motion.position[:: problem.decimation] - problem.link)[rows]))
    one, two = problem.residuals(before.values), problem.residuals(after.values)
    return {
        name: float(np.std((b - a)[rows])) / size for (name, size), a, b in zip(sizes.items(), one, two, strict=True)
    }


def _torque_rms(solver: SteadyFit, fit: Fit) -> float:
    residual = solver.problem.residuals(fit.values)[0][solver.problem.usable]
    return float(np.sqrt(np.mean(residual**2)))


def _weakest(solver: SteadyFit, fit: Fit, keys: Sequence[str], least: float = SIGNIFICANT) -> tuple[str, float] | None:
    """The best-known of the keys with its ratio to its standard deviation, when even that is less than `least`."""
    uncertainty = uncertainty_of(fit, solver.problem.rate_hz)
    ratios = []
    for key in keys:
        std = uncertainty.std(key)
        ratios.append((key, abs(fit.values[key]) / std if std > 0 and np.isfinite(std) else 0.0))
    best = max(ratios, key=lambda item: item[1])
    return best if best[1] < least else None


def final_polish(solver: SteadyFit, fit: Fit) -> Fit:
    """The fit converged once more with the noise's whitening taken from what is left."""
    return solver.solve(fit.free, fit.values, solver.whitenings(fit.values), iterations=ITERATIONS, tolerance=1e-6)


def unstuck(solver: SteadyFit, fit: Fit) -> Fit:
    """The fit, or the one that is found with all nuisances where they start, if that is clearly better.

    What was missing until now had drawn delay, lag and the instants of reversal along, and they may be caught there.
    """
    try:
        again = with_nuisances_anew(solver, fit)
        if again is None:
            return fit
        found = solver.solve(fit.free, again, solver.whitenings(again), iterations=ITERATIONS, tolerance=1e-6)
    except ExcitationError:
        return fit
    return found if clearly_lower(solver, found, fit) else fit
