"""Fits of the search: whitened by the noise alone, compared by likelihood and by parts of the data left out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.estimation.estimate import refined, started_values
from flex_ident.estimation.fit import MEMORY_S, Fit, Prior, SimulationFit
from flex_ident.estimation.nuisances import measurement_priors
from flex_ident.estimation.problem import FitProblem, values_of
from flex_ident.estimation.whitening import Whitening
from flex_ident.gap.noise import noise_whitening
from flex_ident.gap.options import GapOptions
from flex_ident.recording import Floats

FOLDS = 5
BLOCK_S = 0.25


class GapFit(SimulationFit):
    """A fit whose whitening follows the steady noise of the residual, so that model error keeps its weight."""

    def whitenings(self, values: Mapping[str, float]) -> tuple[Whitening, ...]:
        """The whitening filter of each channel's noise at these values."""
        rate = self.problem.rate_hz
        order = int(np.clip(round(MEMORY_S * rate), 4, 48))
        return tuple(noise_whitening(r, self.problem.usable, rate, order) for r in self.problem.residuals(values))


def gap_priors(problem: FitProblem, effects: Sequence[str] = ()) -> dict[str, Prior]:
    """Priors of the measurement keys, delays within one sample: more is an effect. An accepted one replaces its key."""
    priors = measurement_priors(problem, delay_samples=1.0)
    if "time_delay" in effects:
        priors.pop("torque_delay", None)
    if "encoder_skew" in effects:
        priors.pop("link_skew", None)
    if "saturation" in effects:  # a limit near zero would clip the measurement itself away
        largest = float(np.max(np.abs(problem.recording.motor_torque)))
        priors["saturation.limit"] = Prior(0.7 * largest, 100.0 * largest, 0.35 * largest, 1.1 * largest)
    return priors


def base_keys(options: GapOptions) -> tuple[str, ...]:
    """Keys of the base model, effects of a given model included."""
    keys = tuple(k for k in options.base_catalogue if k not in options.without)
    if options.model is None:
        return keys
    given = tuple(k for k in values_of(options.model) if k not in options.without)
    return tuple(dict.fromkeys((*keys, *given)))


def base_fit(problem: FitProblem, options: GapOptions) -> tuple[GapFit, Fit]:
    """The base model fitted to everything, and the solver that did it. Raises ExcitationError."""
    keys = base_keys(options)
    if options.model is not None:
        given = values_of(options.model)
        start = {k: given.get(k, 0.0) for k in keys}
    else:
        found = started_values(problem, keys, first_mode_hz=options.first_mode_hz)
        start = {k: found.get(k, 0.0) for k in keys}
    priors = gap_priors(problem, [k.split(".")[0] for k in keys if "." in k])
    free = (*keys, *priors)
    values = refined(SimulationFit(problem, priors=priors), free, start).values
    solver = GapFit(problem, priors=priors)
    fit = solver.solve(free, values, solver.whitenings(values), iterations=12, tolerance=1e-5)
    fit = solver.solve(free, fit.values, solver.whitenings(fit.values), iterations=8, tolerance=1e-5)
    return solver, fit


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


def block_numbers(problem: FitProblem, fit: Fit) -> NDArray[np.int64]:
    """The block of time (r,) that each whitened residual belongs to."""
    return np.concatenate([(problem.time[rows] / BLOCK_S).astype(np.int64) for rows in fit.rows])


def left_out_costs(problem: FitProblem, fit: Fit) -> Floats:
    """Squared whitened residual of each block of a second, predicted by a fit that did not see it (blocks,).

    One Gauss-Newton step from the optimum, exact for a linear problem; every fifth block is left out together.
    """
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    jacobian = fit.jacobian[:, inside]
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    jacobian = jacobian / scale
    prior = fit.prior_information[np.ix_(inside, inside)] / np.outer(scale, scale)
    information = jacobian.T @ jacobian + prior + 1e-10 * np.eye(len(inside))
    blocks = block_numbers(problem, fit)
    costs = np.zeros(int(blocks.max()) + 1)
    for fold in range(FOLDS):
        rows = blocks % FOLDS == fold
        part, rest = jacobian[rows], fit.residual[rows]
        step = np.linalg.lstsq(information - part.T @ part, part.T @ rest, rcond=1e-12)[0]
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
