"""Fits weighted by the noise that the recording itself shows, not by what the model leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from flex_ident.likelihood.fit import MEMORY_S, Fit, Prior, SimulationFit, key_bounds
from flex_ident.likelihood.noise import encoder_noise, noise_whitening
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.reversals import Mark, ReversalWeights, dry_friction, friction_marks
from flex_ident.likelihood.thresholds import LOUDER
from flex_ident.likelihood.whitening import Whitening
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats

Indices = NDArray[np.int64]
STATE = ("initial_deflection", "initial_velocity")
"""The link's state at the start."""
LOCAL_S = 2.0
"""Stretch over which the size of what is left is taken, s."""


class NoiseWhitening(Whitening):
    """A whitening filter of a channel's noise that knows where friction of a size, N m, is unknown, and where (m,) the
    model leaves more than noise."""

    def __init__(
        self, filtered: Whitening, marks: tuple[Mark, ...] = (), friction: float = 0.0, local: Floats | None = None
    ) -> None:
        super().__init__(filtered.coefficients, filtered.scale)
        self.__dict__.update(_marks=marks, _friction=friction, _weights={}, _local=local)

    def weights(self, rows: Indices) -> ReversalWeights:
        """What takes unknown friction out of residuals of these rows."""
        known: tuple[Indices, ReversalWeights] | None = self.__dict__["_weights"].get(rows.size)
        if known is None or not np.array_equal(known[0], rows):
            known = (rows, ReversalWeights(self.__dict__["_marks"], self.__dict__["_friction"], self, rows))
            self.__dict__["_weights"][rows.size] = known
        return known[1]

    def weighted(self, whitened: Floats, rows: Indices) -> Floats:
        """Whitened residuals of these rows, (r,) or (r, k), with little weight where the model is not to be trusted."""
        if self.__dict__["_friction"] > 0.0:
            whitened = self.weights(rows)(whitened)
        local: Floats | None = self.__dict__["_local"]
        if local is None:
            return whitened
        divided: Floats = (whitened.T / local[rows]).T
        return divided

    def localised(self, local: Floats) -> NoiseWhitening:
        """The same with residuals divided by `local` (m,)."""
        return NoiseWhitening(self, self.__dict__["_marks"], self.__dict__["_friction"], local)


class SteadyFit(SimulationFit):
    """A fit whose weights follow the steady noise of the residual, so that model error keeps its weight.

    `local`: stretches in which the model leaves more than noise weigh as much less. That is the fit to estimate with;
    without it model errors stand out, which is the fit to look for them with.
    """

    def __init__(
        self,
        problem: FitProblem,
        *,
        priors: Mapping[str, Prior] | None = None,
        marks: tuple[Mark, ...] | None = None,
        local: bool = False,
    ) -> None:
        super().__init__(problem, priors=priors)
        self.marks = friction_marks(problem) if marks is None else marks
        self.local = local

    def whitenings(self, values: Values) -> tuple[Whitening, ...]:
        """The whitening filter of each channel's noise at these values. Raises ExcitationError."""
        problem = self.problem
        order = int(np.clip(round(MEMORY_S * problem.rate_hz), 4, 48))
        torque, *others = residuals = self.finite_residuals(values)
        shaken, *apart = self.encoder_noise(values)
        friction = dry_friction(values)
        found = NoiseWhitening(noise_whitening(torque, problem.usable, problem.rate_hz, order, shaken))
        if friction > 0.0:
            rest = torque - self.standstill_friction(torque, NoiseWhitening(found, self.marks, friction))
            steady = noise_whitening(rest, problem.usable, problem.rate_hz, order, shaken)
            found = NoiseWhitening(steady, self.marks, friction)
        links = [
            NoiseWhitening(noise_whitening(r, problem.usable, problem.rate_hz, order, s))
            for r, s in zip(others, apart, strict=True)
        ]
        channels = [found, *links]
        if self.local:
            every = self.rows(tuple(channels))
            channels = [
                w.localised(self._local(w, r, rows)) for w, r, rows in zip(channels, residuals, every, strict=True)
            ]
        return tuple(channels)

    def finished(
        self, keys: Sequence[str], start: Values, whitenings: tuple[Whitening, ...], *, iterations: int,
        tolerance: float, state: bool = True,
    ) -> Fit:  # fmt: skip
        """The fit over `keys`, and once more without the link's state at the start; without `state` only so.

        A link that sticks at first makes the likelihood kink in its state, and no step in all keys together goes on
        from there. Raises ExcitationError.
        """
        if not any(k in STATE for k in keys):
            return self.solve(keys, start, whitenings, iterations=iterations, tolerance=tolerance)
        values = start
        if state:
            values = self.solve(keys, start, whitenings, iterations=iterations, tolerance=tolerance, rough=True).values
        rest = [k for k in keys if k not in STATE]
        there = self.solve(rest, values, whitenings, iterations=iterations, tolerance=tolerance, rough=True)
        ends = {k: key_bounds(k, self.priors) for k in keys if k in STATE}
        at_bound = (*there.at_bound, *(k for k, e in ends.items() if np.isclose(there.values[k], e, rtol=1e-9).any()))
        return replace(self.linearised(keys, there.values, whitenings, at_bound), converged=there.converged)

    def _local(self, whitening: NoiseWhitening, residual: Floats, rows: Indices) -> Floats:
        """By how much (m,) what is left is larger than the noise around, at least 1."""
        power = np.zeros(residual.size)
        power[rows] = whitening.weighted(whitening(residual)[rows], rows) ** 2
        there = np.zeros(residual.size)
        there[rows] = 1.0
        window = max(3, round(LOCAL_S * self.problem.rate_hz))
        mean = ndimage.uniform_filter1d(power, window) / np.maximum(ndimage.uniform_filter1d(there, window), 1e-9)
        louder: Floats = np.sqrt(np.where(mean > LOUDER, mean, 1.0))
        return louder

    def encoder_noise(self, values: Values) -> tuple[Floats, ...]:
        """What the noise of the motor's encoder does to each compared signal (m,) at these values."""
        return encoder_noise(self.problem, values)

    def standstill_friction(self, residual: Floats, whitening: Whitening) -> Floats:
        """The part (m,) of a torque residual (m,), N m, that friction at standstill most probably took."""
        if not isinstance(whitening, NoiseWhitening) or whitening.__dict__["_friction"] <= 0.0:
            return np.zeros_like(residual)
        rows = self.rows((whitening,))[0]
        return whitening.weights(rows).friction(whitening(residual)[rows], residual.size)

    def standstill_size(self, values: Values) -> Floats:
        """Standard deviation (m,), N m, of what friction at standstill adds to the torque where it may be anywhere
        between its two signs."""
        power = np.zeros(self.problem.time.size)
        for mark in self.marks:
            power[mark.first : mark.first + mark.shape.size] += mark.shape**2
        size: Floats = dry_friction(values) * np.sqrt(power / 3.0)
        return size

    def whitened(self, residuals: tuple[Floats, ...], whitenings: tuple[Whitening, ...]) -> Floats:
        """All channels' whitened residuals in one vector (r,), with little weight on friction at standstill."""
        return self._weighted(super().whitened(residuals, whitenings), whitenings)

    def whitened_jacobian(self, values: Values, keys: Sequence[str], whitenings: tuple[Whitening, ...]) -> Floats:
        """Derivative (r, p) of the whitened residual with respect to the keys' values."""
        return self._weighted(super().whitened_jacobian(values, keys, whitenings), whitenings)

    def _weighted(self, whitened: Floats, whitenings: tuple[Whitening, ...]) -> Floats:
        parts, first = [], 0
        for whitening, rows in zip(whitenings, self.rows(whitenings), strict=True):
            part = whitened[first : first + rows.size]
            parts.append(whitening.weighted(part, rows) if isinstance(whitening, NoiseWhitening) else part)
            first += rows.size
        return np.concatenate(parts)
