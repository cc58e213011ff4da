"""Fits of the search: whitened by the noise alone, compared by likelihood and by parts of the data left out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.effects import effect_named
from flex_ident.estimation.estimate import refined, started_values
from flex_ident.estimation.fit import MEMORY_S, Fit, Prior, SimulationFit
from flex_ident.estimation.nuisances import measurement_priors
from flex_ident.estimation.problem import FitProblem, values_of
from flex_ident.estimation.whitening import Whitening
from flex_ident.gap.minimising import bounded_minimum
from flex_ident.gap.noise import noise_whitening
from flex_ident.gap.options import GapOptions
from flex_ident.gap.reversals import Mark, ReversalWeights, dry_friction, friction_marks
from flex_ident.parameters.keys import effect_in, key_text
from flex_ident.recording import Floats

Indices = NDArray[np.int64]
FOLDS = 5
FOLD_S = 0.25
"""Every fifth quarter of a second is left out together: of a resonance passed once the rest stays in."""
FARTHEST = 3.0
"""Standard deviations, rms over the parameters, that leaving blocks out may move a fit."""
BLOCK_S = 0.25
"""Left-out costs are compared block by block: a resonance is crossed in a few seconds."""


class NoiseWhitening(Whitening):
    """A whitening filter of the torque's noise that knows where friction of a size, N m, is unknown."""

    def __init__(self, filtered: Whitening, marks: tuple[Mark, ...], friction: float) -> None:
        super().__init__(filtered.coefficients, filtered.scale)
        self.__dict__.update(_marks=marks, _friction=friction, _weights={})

    def weights(self, rows: Indices) -> ReversalWeights:
        """What takes unknown friction out of residuals of these rows."""
        known: tuple[Indices, ReversalWeights] | None = self.__dict__["_weights"].get(rows.size)
        if known is None or not np.array_equal(known[0], rows):
            known = (rows, ReversalWeights(self.__dict__["_marks"], self.__dict__["_friction"], self, rows))
            self.__dict__["_weights"][rows.size] = known
        return known[1]


class GapFit(SimulationFit):
    """A fit whose weights follow the steady noise of the residual, so that model error keeps its weight."""

    def __init__(
        self,
        problem: FitProblem,
        *,
        priors: Mapping[str, Prior] | None = None,
        marks: tuple[Mark, ...] | None = None,
    ) -> None:
        super().__init__(problem, priors=priors)
        self.marks = friction_marks(problem) if marks is None else marks

    def whitenings(self, values: Mapping[str, float]) -> tuple[Whitening, ...]:
        """The whitening filter of each channel's noise at these values."""
        problem = self.problem
        order = int(np.clip(round(MEMORY_S * problem.rate_hz), 4, 48))
        torque, *others = problem.residuals(values)
        friction = dry_friction(values)
        rest, found = torque, noise_whitening(torque, problem.usable, problem.rate_hz, order)
        if friction > 0.0:
            rest = torque - self.standstill_friction(torque, NoiseWhitening(found, self.marks, friction))
            found = noise_whitening(rest, problem.usable, problem.rate_hz, order)
            found = NoiseWhitening(found, self.marks, friction)
        return (found, *(noise_whitening(r, problem.usable, problem.rate_hz, order) for r in others))

    def standstill_friction(self, residual: Floats, whitening: Whitening) -> Floats:
        """The part (m,) of a torque residual (m,), N m, that friction at standstill most probably took."""
        if not isinstance(whitening, NoiseWhitening):
            return np.zeros_like(residual)
        rows = self._rows((whitening,))[0]
        return whitening.weights(rows).friction(whitening(residual)[rows], residual.size)

    def whitened(self, residuals: tuple[Floats, ...], whitenings: tuple[Whitening, ...]) -> Floats:
        """All channels' whitened residuals in one vector (r,), with little weight on friction at standstill."""
        return self._weighted(super().whitened(residuals, whitenings), whitenings)

    def whitened_jacobian(
        self, values: Mapping[str, float], keys: Sequence[str], whitenings: tuple[Whitening, ...]
    ) -> Floats:
        """Derivative (r, p) of the whitened residual with respect to the keys' values."""
        return self._weighted(super().whitened_jacobian(values, keys, whitenings), whitenings)

    def _minimum(
        self, residual: Callable[[Floats], Floats], jacobian: Callable[[Floats], Floats], start: Floats, lower: Floats,
        upper: Floats, *, iterations: int, tolerance: float, rough: bool,
    ) -> tuple[Floats, Floats, Floats, bool]:  # fmt: skip
        return bounded_minimum(
            residual, jacobian, start, lower, upper, iterations=iterations, tolerance=tolerance, linearised=not rough
        )

    def _weighted(self, whitened: Floats, whitenings: tuple[Whitening, ...]) -> Floats:
        torque = whitenings[0]
        if not isinstance(torque, NoiseWhitening):
            return whitened
        rows = self._rows(whitenings)[0]
        return np.concatenate((torque.weights(rows)(whitened[: rows.size]), whitened[rows.size :]))


def gap_priors(problem: FitProblem, effects: Sequence[str] = ()) -> dict[str, Prior]:
    """Priors of the measurement keys, delays within one sample: more is an effect. An accepted one replaces its key."""
    priors = measurement_priors(problem, delay_samples=1.0)
    if not problem.rigid:
        spread = 0.02 * float(np.std(problem.motion.velocity)) + 1e-9
        priors["initial_velocity"] = Prior(0.0, spread, -20.0 * spread, 20.0 * spread)
    for name in effects:
        effect = effect_named(name)
        priors.pop(effect.replaces, None)
        if effect.priors is not None:
            own = effect.priors(np.abs(problem.recording.motor_torque))
            priors.update({key_text(name, key): prior for key, prior in own.items()})
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
    priors = gap_priors(problem, [e for e in map(effect_in, keys) if e is not None])
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
