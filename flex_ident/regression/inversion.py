"""From the seven X of eq. 19 to physical parameters: Table 3's route, and a weighted inversion of all seven."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from flex_ident.recording import Floats
from flex_ident.regression.least_squares import LinearFit

PHYSICAL = ("Jm", "K", "JL", "FVm", "FSm", "FV")


@dataclass(frozen=True)
class Inversion:
    """Physical parameters (6,) in the order of PHYSICAL with covariance (6, 6).

    `x5_predicted` is X5 computed from them, `x5_sigmas` its distance from the X5 of the fit in standard deviations:
    seven X determine six parameters, and the seventh tells whether the model holds.
    """

    values: Floats
    covariance: Floats
    x5_predicted: float
    x5_sigmas: float
    possible: bool


def combined(values: Floats) -> Floats:
    """The seven X (eq. 19) of physical parameters (6,) in the order of PHYSICAL."""
    jm, k, jl, fvm, fsm, fv = values
    return np.array([jl / k, fv / k, jm * jl / k, (jm * fv + jl * fvm) / k, jm + jl + fv * fvm / k, fv + fvm, fsm])


def table_3(fit: LinearFit) -> Inversion:
    """Table 3's inversion, which leaves X5 aside: Jm = X3/X1, FVm = (X4 - Jm X2)/X1, FV = X6 - FVm, K = FV/X2.

    Uncertainties by first-order propagation of the covariance of the X.
    """

    def inverted(x: Floats) -> Floats:
        x1, x2, x3, x4, _, x6, x7 = x
        jm = x3 / x1
        fvm = (x4 - jm * x2) / x1
        fv = x6 - fvm
        k = fv / x2
        return np.array([jm, k, x1 * k, fvm, x7, fv])

    values = inverted(fit.values)
    gradient = _gradient(inverted, fit.values)
    return _judged(fit, values, gradient @ fit.covariance @ gradient.T, exclude_x5=True)


def weighted_inversion(fit: LinearFit) -> Inversion:
    """The six parameters that reproduce all seven X best, weighted with their covariance; all positive."""
    start = table_3(fit).values
    total = max(abs(float(fit.value("X5"))), 1e-9)
    jm = float(np.clip(start[0], 0.02 * total, 0.98 * total))
    k = (total - jm) / max(abs(fit.value("X1")), 1e-12)
    x6 = max(abs(fit.value("X6")), 1e-9)
    guess = np.array([jm, k, total - jm, 0.5 * x6, max(fit.value("X7"), 1e-6), 0.5 * x6])
    stds = np.sqrt(np.diag(fit.covariance))
    stds[stds == 0.0] = 1e-300
    correlation = fit.covariance / np.outer(stds, stds)
    whiten = np.linalg.inv(np.linalg.cholesky(correlation + 1e-9 * np.eye(7))) / stds

    def residual(x: Floats) -> Floats:
        result: Floats = whiten @ (combined(np.exp(np.clip(x, -60.0, 60.0))) - fit.values)
        return result

    solution = optimize.least_squares(residual, np.log(guess), x_scale="jac", max_nfev=400)
    values = np.exp(np.clip(solution.x, -60.0, 60.0))
    jacobian = whiten @ _gradient(combined, values)
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    covariance = np.linalg.pinv((jacobian / scale).T @ (jacobian / scale)) / np.outer(scale, scale)
    surplus = max(1.0, 2.0 * float(solution.cost))
    return _judged(fit, values, covariance * surplus, exclude_x5=False)


def _gradient(function: object, x: Floats) -> Floats:
    assert callable(function)
    columns = []
    for i in range(x.size):
        step = 1e-6 * max(abs(float(x[i])), 1e-12)
        up, down = x.copy(), x.copy()
        up[i] += step
        down[i] -= step
        columns.append((function(up) - function(down)) / (2.0 * step))
    return np.column_stack(columns)


def _judged(fit: LinearFit, values: Floats, covariance: Floats, *, exclude_x5: bool) -> Inversion:
    predicted = float(combined(values)[4])
    own = fit.std("X5")
    spread = own
    if exclude_x5:
        gradient = _gradient(combined, values)[4]
        spread = math.sqrt(own**2 + max(float(gradient @ covariance @ gradient), 0.0))
    sigmas = abs(predicted - fit.value("X5")) / spread if spread > 0.0 else math.inf
    possible = bool(np.isfinite(values).all() and values[0] > 0 and values[1] > 0 and values[2] > 0)
    return Inversion(values, covariance, predicted, sigmas, possible)
