"""Fits compared: by likelihood, and by parts of the data that were left out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.recording import Floats

FOLDS = 5
FOLD_S = 0.25
"""Every fifth quarter of a second is left out together: of a resonance passed once the rest stays in."""
FARTHEST = 3.0
"""Standard deviations, rms over the parameters, that leaving blocks out may move a fit."""
BLOCK_S = 0.25
"""Left-out costs are compared block by block: a resonance is crossed in a few seconds."""


def sum_of_squares(fit: Fit) -> float:
    """Sum of the squared whitened residuals: the number of samples, if all that is left is the noise."""
    return 2.0 * fit.cost


def correlation_factor(fit: Fit) -> float:
    """By how much fewer samples are independent than there are, at least 1, from the whitened torque residual."""
    count = fit.rows[0].size
    x = fit.residual[:count]
    x = x - x.mean()
    length = 1 << int(np.ceil(np.log2(2 * count)))
    auto = np.fft.irfft(np.abs(np.fft.rfft(x, length)) ** 2, length)[: max(2, count // 10)]
    rho = auto / auto[0]
    negative = np.flatnonzero(rho < 0.05)
    stop = int(negative[0]) if negative.size else rho.size
    return 1.0 + 2.0 * float(np.sum(rho[1:stop] ** 2)) if stop > 1 else 1.0


def log_likelihood_gain(before: Fit, after: Fit) -> float:
    """Twice the gain in log-likelihood, the noise's size being unknown and what is left correlated."""
    rss0, rss1 = sum_of_squares(before), sum_of_squares(after)
    count = before.residual.size / correlation_factor(after)
    if rss1 < before.residual.size:  # what is left is the noise: its size is known
        return min(count * math.log(rss0 / rss1), rss0 - rss1)
    return count * math.log(rss0 / rss1)


def left_out_costs(problem: FitProblem, fit: Fit) -> Floats:
    """Squared whitened residual of each block of time, predicted by a fit that did not see it (blocks,).

    One Gauss-Newton step from the optimum, exact for a linear problem; no longer than `FARTHEST` allows, for what only
    the left-out blocks tell of the model would otherwise be anything.
    """
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    jacobian = fit.jacobian[:, inside]
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    jacobian = jacobian / scale
    prior = fit.prior_information[np.ix_(inside, inside)] / np.outer(scale, scale)
    information = jacobian.T @ jacobian + prior + 1e-10 * np.eye(len(inside))
    time = np.concatenate([problem.time[rows] for rows in fit.rows])
    blocks, folds = (time / BLOCK_S).astype(np.int64), (time / FOLD_S).astype(np.int64) % FOLDS
    costs = np.zeros(int(blocks.max()) + 1)
    variance = max(1.0, float(fit.residual @ fit.residual) / fit.residual.size)
    for fold in range(FOLDS):
        rows = folds == fold
        part, rest = jacobian[rows], fit.residual[rows]
        step = np.linalg.lstsq(information - part.T @ part, part.T @ rest, rcond=1e-12)[0]
        length = math.sqrt(max(float(step @ information @ step), 0.0) / (variance * len(inside)))
        step *= min(1.0, FARTHEST / length) if length > 0.0 else 1.0
        np.add.at(costs, blocks[rows], (rest + part @ step) ** 2)
    return costs[np.unique(blocks)]


@dataclass(frozen=True)
class HeldOut:
    """What left-out blocks say of one model against another: share of the cost saved, and its t value over blocks."""

    share: float
    t: float


def held_out_comparison(problem: FitProblem, before: Fit, after: Fit) -> HeldOut:
    """Whether `after` predicts blocks that it did not see better than `before`."""
    one, two = left_out_costs(problem, before), left_out_costs(problem, after)
    saved = one - two
    spread = float(np.std(saved, ddof=1)) * math.sqrt(saved.size)
    return HeldOut(float(saved.sum() / one.sum()), float(saved.sum()) / spread if spread > 0 else 0.0)
