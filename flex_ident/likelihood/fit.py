"""Maximum likelihood by simulation: nonlinear least squares on whitened residuals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flex_ident.effects import key_named
from flex_ident.errors import ExcitationError
from flex_ident.likelihood.gauge import agreed, gauge_information
from flex_ident.likelihood.minimising import bounded_minimum
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.whitening import Whitening, settled, whitening_of
from flex_ident.parameters.prior import Prior as Prior
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats

RELATIVE_STEP = 3e-6
"""Small: where two keys are nearly parallel, the curvature over a larger step passes for their difference."""
MEMORY_S = 0.35
"""Memory of the whitening filter, s."""


@dataclass(frozen=True)
class Fit:
    """The optimum: the `values` of every key (free or not), and the linearised problem there.

    `jacobian` (r, p) and `residual` (r,) are whitened to unit variance, priors excluded, rows in the order of
    `rows` (indices into the decimated clock, one entry a channel); `prior_information` (p, p). Columns are per unit
    of the value itself, not of its logarithm.
    """

    free: tuple[str, ...]
    values: Values
    jacobian: Floats
    residual: Floats
    rows: tuple[NDArray[np.int64], ...]
    prior_information: Floats
    whitenings: tuple[Whitening, ...]
    at_bound: tuple[str, ...]
    cost: float
    """Half the sum of squares of the whitened residual."""
    converged: bool = True
    """Whether the search for it ended by itself."""
    rival: Values | None = None
    """Where another start led that is as likely; None where none did."""


def key_scale(problem: FitProblem, key: str, value: float) -> float:
    """A step size, absolute, in which the value of a key is naturally measured."""
    torque, position, velocity, acceleration = problem.spread
    ts = problem.recording.sample_time
    match key:
        case "Jm" | "JL" | "J":
            return max(abs(value), 1e-3 * torque / acceleration)
        case "K":
            return max(abs(value), 1e-3 * torque / position)
        case "FVm" | "FV":
            return max(abs(value), 0.05 * torque / velocity)
        case "FSm" | "FS" | "offset":
            return max(abs(value), 0.05 * torque)
        case "MX" | "MY":
            return max(abs(value), 0.05 * torque / 9.81)
        case "torque_delay" | "link_skew" | "reversal_lead" | "effort_lag":
            return ts
        case "friction_removed":
            return max(abs(value), 0.05 * torque)
        case "reversal_speed" | "friction_removed_speed":
            return max(abs(value), 1e-3 * velocity)
        case "presliding":
            return max(abs(value), 1e-3 * position)
        case "torque_averaging" | "far_mode":
            return 0.1
        case "link_drift":
            return ts / float(problem.time[-1])
        case "link_scale":
            return 1e-2
        case "link_zero" | "initial_deflection":
            return 1e-2 * position
        case "initial_velocity":
            return 1e-2 * velocity
        case _:
            return max(abs(value), 1e-3)


def key_bounds(key: str, priors: Mapping[str, Prior]) -> tuple[float, float]:
    """The range that physics allows a key."""
    if key in priors:
        return priors[key].lower, priors[key].upper
    known = key_named(key)
    return known.lower, known.upper


class SimulationFit:
    """Fits chosen keys of a `FitProblem`; whitening filters are held fixed during one `solve`."""

    def __init__(self, problem: FitProblem, *, priors: Mapping[str, Prior] | None = None) -> None:
        self.problem = problem
        self.priors: dict[str, Prior] = dict(priors or {})

    def whitenings(self, values: Values) -> tuple[Whitening, ...]:
        """The whitening filter of each channel's residual at these values. Raises ExcitationError."""
        order = int(np.clip(round(MEMORY_S * self.problem.rate_hz), 4, 64))
        return tuple(whitening_of(r, self.problem.usable, order) for r in self.finite_residuals(values))

    def finite_residuals(self, values: Values) -> tuple[Floats, ...]:
        """The residuals (m,) at these values. Raises ExcitationError where the simulation runs away."""
        residuals = self.problem.residuals(values)
        if not all(np.isfinite(r).all() for r in residuals):
            raise ExcitationError("the simulation of a model that was tried runs away: give --first-mode or --model.")
        return residuals

    def rows(self, whitenings: tuple[Whitening, ...]) -> tuple[NDArray[np.int64], ...]:
        """The samples of each channel that a whitened residual is made of."""
        return tuple(np.flatnonzero(settled(self.problem.usable, w.memory)) for w in whitenings)

    def whitened_residual(self, values: Values, whitenings: tuple[Whitening, ...]) -> Floats:
        """All channels' whitened residuals in one vector (r,)."""
        return self.whitened(self.problem.residuals(values), whitenings)

    def whitened_residuals(self, many: Sequence[Values], whitenings: tuple[Whitening, ...]) -> list[Floats]:
        """The same (r,) for each of several sets of values, simulated together."""
        return [self.whitened(residuals, whitenings) for residuals in self.problem.residuals_of_many(many)]

    def whitened(self, residuals: tuple[Floats, ...], whitenings: tuple[Whitening, ...]) -> Floats:
        """Residuals (m,) of each channel, or changes of them, whitened, in one vector (r,)."""
        rows = self.rows(whitenings)
        return np.concatenate([w(r)[i] for w, r, i in zip(whitenings, residuals, rows, strict=True)])

    def whitened_jacobian(self, values: Values, keys: Sequence[str], whitenings: tuple[Whitening, ...]) -> Floats:
        """Derivative (r, p) of the whitened residual with respect to the keys' values."""
        steps = {k: RELATIVE_STEP * key_scale(self.problem, k, values.get(k, 0.0)) for k in keys}
        for key in keys:  # step inwards where the bound is near
            _, upper = key_bounds(key, self.priors)
            if values.get(key, 0.0) + steps[key] > upper:
                steps[key] = -steps[key]
        rows = self.rows(whitenings)
        parts = self.problem.sensitivities(values, keys, steps)
        return np.concatenate([w(c)[i] for w, c, i in zip(whitenings, parts, rows, strict=True)])

    def solve(
        self,
        keys: Sequence[str],
        start: Values,
        whitenings: tuple[Whitening, ...],
        *,
        iterations: int = 30,
        tolerance: float = 1e-8,
        rough: bool = False,
    ) -> Fit:
        """Minimise over `keys` from `start`. Raises ExcitationError when no simulation near the start is finite.

        `rough` spares the last Jacobian: that of the result is the one before the last step.
        """
        keys = tuple(keys)
        values = Values({k: self.priors[k].start for k in keys if k in self.priors}) | start
        logarithmic = np.array([key_named(k).logarithmic for k in keys])
        scale = np.array([key_scale(self.problem, k, values.get(k, 0.0)) for k in keys])

        def unpacked(x: Floats) -> Values:
            numbers = np.where(logarithmic, np.exp(np.clip(x, -60.0, 60.0)), x * scale)
            return values.with_vector(keys, numbers)

        def packed(key: str, value: float, s: float) -> float:
            return float(np.log(max(value, 1e-12))) if key_named(key).logarithmic else value / s

        prior_keys = [(i, self.priors[k]) for i, k in enumerate(keys) if k in self.priors]

        def residual(x: Floats) -> Floats:
            now = unpacked(x)
            main = self.whitened_residual(now, whitenings)
            main = np.where(np.isfinite(main), main, 1e6)
            tail = [(now[keys[i]] - p.mean) / p.std for i, p in prior_keys]
            return np.concatenate((main, tail))

        def jacobian(x: Floats) -> Floats:
            now = unpacked(x)
            main = self.whitened_jacobian(now, keys, whitenings)
            main = np.where(np.isfinite(main), main, 0.0)
            tail = np.zeros((len(prior_keys), len(keys)))
            for row, (i, p) in enumerate(prior_keys):
                tail[row, i] = 1.0 / p.std
            factor = np.where(logarithmic, [now[k] for k in keys], scale)
            full: Floats = np.concatenate((main, tail)) * factor
            return full

        lower, upper = np.empty(len(keys)), np.empty(len(keys))
        x0 = np.empty(len(keys))
        for i, key in enumerate(keys):
            low, high = key_bounds(key, self.priors)
            if logarithmic[i]:
                low, high = float(np.exp(-30.0)), float(np.exp(60.0))
            lower[i] = packed(key, low, scale[i]) if np.isfinite(low) else low
            upper[i] = packed(key, high, scale[i]) if np.isfinite(high) else high
            x0[i] = np.clip(packed(key, values.get(key, 0.0), scale[i]), lower[i], upper[i])
        if not any(rows.size for rows in self.rows(whitenings)):
            raise ExcitationError(
                "the motor never moves for long enough without standing still: record a motion that goes on, a chirp."
            )
        if not np.isfinite(self.whitened_residual(unpacked(x0), whitenings)).all():
            raise ExcitationError("the simulation of the starting model runs away: give --first-mode or --model.")
        x, rest, slope, converged = bounded_minimum(
            residual, jacobian, x0, lower, upper, iterations=iterations, tolerance=tolerance, linearised=not rough
        )
        near = 1e-4
        at_bound, reached = [], x.copy()
        for i, key in enumerate(keys):
            if logarithmic[i]:
                continue
            if x[i] - lower[i] < near or upper[i] - x[i] < near:
                x[i] = lower[i] if x[i] - lower[i] < near else upper[i]
                at_bound.append(key)
        moved = unpacked(x)
        found = agreed(keys, moved, lambda k: key_bounds(k, self.priors))
        at_bound = [k for k in at_bound if found[k] == moved[k]]
        if (x != reached).any() or found != moved:
            return replace(self.linearised(keys, found, whitenings, tuple(at_bound)), converged=converged)
        count = rest.size - len(prior_keys)
        units = np.where(logarithmic, [found[k] for k in keys], scale)
        known = (rest[:count], slope[:count] / units)
        linearised = self.linearised(keys, found, whitenings, tuple(at_bound), known=known)
        return replace(linearised, converged=converged)

    def linearised(
        self,
        keys: Sequence[str],
        values: Values,
        whitenings: tuple[Whitening, ...],
        at_bound: tuple[str, ...] = (),
        *,
        known: tuple[Floats, Floats] | None = None,
    ) -> Fit:
        """The whitened problem, linearised at `values`; `known` are residual and Jacobian where they are at hand."""
        information = np.zeros((len(keys), len(keys)))
        for i, key in enumerate(keys):
            if key in self.priors:
                information[i, i] = 1.0 / self.priors[key].std ** 2
        information += gauge_information(keys, values, at_bound, self.priors)
        rest = known[0] if known else self.whitened_residual(values, whitenings)
        slope = known[1] if known else self.whitened_jacobian(values, keys, whitenings)
        # A simulation that runs away beside the optimum tells nothing of its slope: such columns are undetermined.
        rest, slope = np.where(np.isfinite(rest), rest, 1e6), np.where(np.isfinite(slope), slope, 0.0)
        return Fit(
            free=tuple(keys),
            values=values,
            jacobian=slope,
            residual=rest,
            rows=self.rows(whitenings),
            prior_information=information,
            whitenings=whitenings,
            at_bound=at_bound,
            cost=0.5 * float(rest @ rest),
        )
