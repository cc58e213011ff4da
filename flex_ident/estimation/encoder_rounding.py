"""What the noise of the motor's encoder does to a fit that takes the motion as known, and how large that may be.

The model predicts the torque from the recorded position. Noise on that position is in the prediction and in its
sensitivities alike; their product does not vanish on average, and a fast inertia comes out too small (errors in
variables). Recorded positions with as much noise again, once added and once subtracted, move the fit by a part that
changes its sign, and by the bias again, which does not (simulation extrapolation: Cook and Stefanski 1994). One step of
Gauss and Newton's is enough for both. The size is right, the sign is not always: taken off, it halved the error of
joints whose controller acts on the rounded position and doubled that of others, so it only widens the intervals.
"""

from __future__ import annotations

import numpy as np

from flex_ident.estimation.thresholds import ROUNDING_DRAWS, ROUNDING_MATTERS
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.noise import position_noise
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.recording import Floats


def rounding_bias(solver: SteadyFit, fit: Fit) -> Floats | None:
    """What the encoder's noise adds to the free values (p,) on average; None where it is far below their uncertainty.

    The mean of some draws of that noise, of fixed seeds.
    """
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    if not inside:
        return None
    here = _step(solver, fit, fit.residual, fit.jacobian, inside)
    std = np.sqrt(np.maximum(np.diag(np.linalg.pinv(_information(fit, inside))), 0.0))
    joint = [i for i, place in enumerate(inside) if fit.free[place] not in solver.priors]
    found: list[Floats] = []
    for seed in range(ROUNDING_DRAWS):
        found.append(_moved(solver, fit, inside, seed) - here)
        if seed == 0 and not (np.abs(found[0]) > ROUNDING_MATTERS * std)[joint].any():
            return None
    bias = np.zeros(len(fit.free))
    bias[inside] = np.mean(found, axis=0)
    return bias


def _information(fit: Fit, inside: list[int]) -> Floats:
    slopes = fit.jacobian[:, inside]
    known: Floats = slopes.T @ slopes + fit.prior_information[np.ix_(inside, inside)]
    return known


def _moved(solver: SteadyFit, fit: Fit, inside: list[int], seed: int) -> Floats:
    """The mean step of the values inside their bounds under one draw of noise, added and subtracted."""
    problem = solver.problem
    noise = np.random.default_rng(seed).standard_normal(problem.recording.motor_position.size)
    steps = []
    for size in (position_noise(problem), -position_noise(problem)):
        other = SteadyFit(problem.shifted(size * noise, direction=True), priors=solver.priors, marks=solver.marks)
        residual = other.whitened_residual(fit.values, fit.whitenings)
        jacobian = other.whitened_jacobian(fit.values, fit.free, fit.whitenings)
        steps.append(_step(solver, fit, residual, jacobian, inside))
    mean: Floats = np.mean(steps, axis=0)
    return mean


def _step(solver: SteadyFit, fit: Fit, residual: Floats, jacobian: Floats, inside: list[int]) -> Floats:
    """One step of Gauss and Newton's from the fit, of the values inside their bounds."""
    known = np.sqrt(np.diag(fit.prior_information))[inside]
    off = np.array([solver.priors[k].mean - fit.values[k] if k in solver.priors else 0.0 for k in fit.free])[inside]
    rows = np.vstack((jacobian[:, inside], np.diag(known)))
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0.0] = 1.0
    target = np.nan_to_num(np.concatenate((-residual, known * off)))
    solution: Floats = np.linalg.lstsq(np.nan_to_num(rows / scale), target, rcond=1e-9)[0] / scale
    return solution
