"""What a fit leaves of the torque: its noise and where that is known from, what repeats, and whether more is left."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.noise import is_quiet, link_noise, noise_above_band, noise_floor
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.repeats import Repeats, repeated
from flex_ident.likelihood.reversals import stuck
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.likelihood.thresholds import (
    LEAST_KNOWN,
    OWN_ERROR,
    OWN_ERROR_AT_REVERSALS,
    OWN_ERROR_OF_LINK,
    OWN_ERROR_RINGING,
    STRUCTURE,
)
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats


@dataclass(frozen=True)
class LinkRemainder:
    """What is left of the link's position, its noise, and the deflection of the spring; rad rms."""

    gap: float
    floor: float
    deflection: float

    @property
    def structured(self) -> bool:
        """Whether it holds more than noise and the method's own error."""
        return self.gap > STRUCTURE * self.floor and self.gap > OWN_ERROR_OF_LINK * self.deflection


STRETCH_S = 0.5
"""Stretch over which what rounding moves is held against what is left, s. Set by hand: a few periods of the mode."""
BURST_S = (0.5, 1.0, 2.0, 3.0, 5.0)
"""Lengths of a short stretch, s, the shortest that holds enough being told."""
BURST_SHARE, BURST_HOLDS = 0.15, 0.6
"""Share of the recording that it may be, and of what is more than noise that it must hold. Set by hand."""
Evidence = Literal["repeats", "above_band", "quiet", "none"]
"""What tells the noise from the gap: what does not repeat, what lies above the motion, quiet cells, nothing."""


@dataclass(frozen=True)
class Remainder:
    """Torque residual (m,) of a fit; its size, its noise floor and the method's own error, N m rms."""

    residual: Floats
    gap: float
    floor: float
    own_error: float
    repeats: Repeats | None
    evidence: Evidence
    link: LinkRemainder | None = None
    """Of the link's position; None without a link encoder."""

    def burst(self, time: Floats) -> tuple[float, float] | None:
        """From when to when, s, most is left that is more than noise; None where that is no short stretch.

        `time` (m,), s, of the residual.
        """
        more = np.maximum(self.residual**2 - self.floor**2, 0.0)
        total = np.concatenate(([0.0], np.cumsum(more)))
        if total[-1] <= 0.0:
            return None
        whole = float(time[-1] - time[0])
        for seconds in BURST_S:
            width = int(np.searchsorted(time, time[0] + seconds))
            if seconds > BURST_SHARE * whole or width >= more.size:
                return None
            within = total[width:] - total[:-width]
            at = int(np.argmax(within))
            if within[at] > BURST_HOLDS * total[-1]:
                return float(time[at]), float(time[at]) + seconds
        return None

    def structured(self, gap: float) -> bool:
        """Whether a gap, N m rms, holds more than noise and the method's own error."""
        return gap > STRUCTURE * self.floor and math.sqrt(max(gap**2 - self.floor**2, 0.0)) > self.own_error


def remainder(solver: SteadyFit, fit: Fit, where: NDArray[np.bool_] | None = None) -> Remainder:
    """What that fit leaves at the rows (m,) of `where`, or all that are usable.

    Where the motor sticks, friction is what no model can know: such samples are not counted. At its reversals what that
    friction explains is noise, as far as dry friction that may be anywhere between its two signs makes so much.
    """
    problem = solver.problem
    rows = problem.usable
    shown = counted(problem, rows if where is None else where)
    residual, *others = problem.residuals(fit.values)
    standstill = solver.standstill_friction(residual, solver.whitenings(fit.values)[0])
    shaken = solver.encoder_noise(fit.values)
    rounding = _rounding(shaken[0], residual - standstill, problem.rate_hz, shown)
    noise, evidence, repeats = _noise(solver, residual - standstill, rounding)
    torque, gap = _rms(problem.torque[rows]), _rms(residual[shown])
    explained = math.sqrt(max(gap**2 - _rms((residual - standstill)[shown]) ** 2, 0.0))
    still = min(explained, _rms(solver.standstill_size(fit.values)[shown]))
    link = None
    if others and problem.link is not None:
        deflection = (problem.motion.position[:: problem.decimation] - problem.link)[shown]
        floor = math.hypot(link_noise(problem), _rounding(shaken[1], others[0], problem.rate_hz, shown))
        link = LinkRemainder(_rms(others[0][shown]), floor, float(np.std(deflection)))
    own_error = _own_error(torque, fit.values)
    return Remainder(residual, gap, math.hypot(noise, still), own_error, repeats, evidence, link)


def counted(problem: FitProblem, where: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Those of the rows (m,) at which friction is known: all but where the motor sticks, unless that is nearly all."""
    known = where & ~stuck(problem)
    return known if np.count_nonzero(known) > LEAST_KNOWN * np.count_nonzero(where) else where


def _rounding(shaken: Floats, residual: Floats, rate_hz: float, shown: NDArray[np.bool_]) -> float:
    """What an encoder's rounding may have left, rms over the `shown` rows (m,): what as much noise moves the prediction
    by, `shaken` (m,); where that is more than the whole `residual` (m,), in no stretch more than is left there.

    Play makes it strike another time, which moves the prediction by far more than was left: behind a backlash of 2 mrad
    that was 0.68 N m where 0.19 were left, of which a Stribeck peak was three quarters. Stretch by stretch in any case
    it would be too little: a spring rings now more, now less, and not when the made-up noise has it ring.
    """
    if _rms(shaken[shown]) <= _rms(residual[shown]):
        return _rms(shaken[shown])
    width = max(3, round(STRETCH_S * rate_hz))
    moved, left = (ndimage.uniform_filter1d(signal**2, width) for signal in (shaken, residual))
    return math.sqrt(float(np.mean(np.minimum(moved, left)[shown])))


def _rms(signal: Floats) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def _noise(solver: SteadyFit, residual: Floats, rounding: float) -> tuple[float, Evidence, Repeats | None]:
    """Noise of the torque, N m rms, with what the encoder's `rounding` leaves; what it is known from, and what repeats
    where the motion does."""
    problem = solver.problem
    repeats = repeated(problem, residual, problem.usable)
    if repeats is not None:
        return repeats.noise, "repeats", repeats
    steady = noise_floor(residual, problem.usable, problem.rate_hz)
    above = noise_above_band(problem)
    if above is not None:
        return math.hypot(min(steady, above), rounding), "above_band", None
    return math.hypot(steady, rounding), "quiet" if is_quiet(problem, steady) else "none", None


def coulomb(values: Values) -> float:
    """Dry friction of motor and link together, N m."""
    return abs(values.get("FSm", 0.0)) + abs(values.get("FS", 0.0))


def _own_error(torque: float, values: Values) -> float:
    """What the method itself leaves, N m rms, of a torque of that rms, N m, and the friction in `values`."""
    ringing = OWN_ERROR_RINGING * abs(values.get("FS", 0.0)) if "K" in values and "FSm" not in values else 0.0
    return math.hypot(OWN_ERROR * torque, math.hypot(OWN_ERROR_AT_REVERSALS * coulomb(values), ringing))
