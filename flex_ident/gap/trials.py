"""A candidate refitted together with the whole model, and what speaks for and against accepting it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.effects import CATALOGUE, effect_named
from flex_ident.errors import ExcitationError
from flex_ident.estimation.base_fit import clearly_lower, with_nuisances_anew
from flex_ident.gap.objections import objection_to, values_with
from flex_ident.gap.thresholds import WORTH_ANOTHER
from flex_ident.likelihood.comparison import HeldOut, correlation_factor, held_out_comparison, log_likelihood_gain
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.remainder import coulomb
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.likelihood.thresholds import OWN_ERROR_AT_REVERSALS
from flex_ident.notices import Reason
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import Candidate
from flex_ident.screening.sketching import extended_solver, raced

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
    objection: Reason | None
    """What speaks against it; None where nothing does."""

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
    objection = objection_to(solver, before, after, candidate, evidence, held, (excess_before, share), imitable)
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
