"""The noise under a residual that still holds model error: its spectrum, its whitening filter, its floor."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, ndimage

from flex_ident.filtering.spectral import lowpass_response
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.thresholds import ABOVE, HIGHEST, QUANTILE, QUIET_RATIO, WIDE_ENOUGH
from flex_ident.likelihood.whitening import FLOOR, Whitening
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.recording.noise import resolution
from flex_ident.recording.recording import Role

SEGMENT_S = 1.0
AROUND = 3
"""Samples around a reversal. Set by hand: the low-pass reaches about as far."""


def noise_spectrum(residual: Floats, usable: NDArray[np.bool_], rate_hz: float) -> Floats:
    """Two-sided power spectrum (s // 2 + 1,), unit^2 per bin of s samples, of the steady part of a residual (m,).

    At each frequency the 30 % quantile over half-overlapping segments of a second, over what it is for Gaussian
    noise (power is exponentially distributed), then the median over neighbouring frequencies. The lowest bins, where
    a constant error never goes away, are taken from their neighbours.
    """
    size = max(16, 2 * round(0.5 * SEGMENT_S * rate_hz))
    power = _powers(residual, usable, size)
    level = np.quantile(power, QUANTILE, axis=0) / -math.log(1.0 - QUANTILE)
    level[:3] = np.median(level[3:8])
    smooth: Floats = np.exp(ndimage.median_filter(np.log(np.maximum(level, 1e-300)), 7, mode="nearest"))
    return smooth


def noise_whitening(
    residual: Floats, usable: NDArray[np.bool_], rate_hz: float, order: int, shaken: Floats | None = None
) -> Whitening:
    """The filter that whitens the steady part of a residual (m,) to unit variance; model error stays visible.

    `shaken` (m,) is what the encoder's rounding alone would leave: there is at least as much noise at each frequency.
    """
    spectrum = noise_spectrum(residual, usable, rate_hz)
    if shaken is not None:
        size = 2 * (spectrum.size - 1)
        spectrum = np.maximum(spectrum, np.mean(_powers(shaken, usable, size), axis=0))
    size = 2 * (spectrum.size - 1)
    autocovariance = np.fft.irfft(spectrum, size)
    order = min(order, size // 2 - 1)
    # A short window over the lags: the spectrum's own estimation noise must not become filter.
    lags = np.arange(order + 1)
    autocovariance = autocovariance[: order + 1] * (0.5 + 0.5 * np.cos(math.pi * lags / (order + 1)))
    if autocovariance[0] <= 0.0:
        return Whitening(np.ones(1), 1.0)
    autocovariance[0] *= 1.0 + FLOOR
    prediction = linalg.solve_toeplitz(autocovariance[:-1], autocovariance[1:])
    coefficients = np.concatenate(([1.0], -prediction))
    variance = float(autocovariance[0] - prediction @ autocovariance[1:])
    return Whitening(coefficients, math.sqrt(max(variance, 1e-300)))


def noise_floor(residual: Floats, usable: NDArray[np.bool_], rate_hz: float) -> float:
    """Root mean square, in the residual's unit, of its steady part."""
    spectrum = noise_spectrum(residual, usable, rate_hz)
    return math.sqrt(float(np.mean(np.fft.irfft(spectrum, 2 * (spectrum.size - 1))[:1])))


def noise_above_band(problem: FitProblem) -> float | None:
    """Root mean square, N m, of white noise in the compared torque that the recorded torque shows above the motion.

    None where the recording's rate leaves no room above. Noise that falls with frequency is larger in the band than
    this says, noise that rises (an encoder's rounding, differentiated by a controller) smaller.
    """
    torque, rate = problem.recording.motor_torque, problem.recording.sample_rate_hz
    low, high = ABOVE[0] * problem.cutoff_hz, min(ABOVE[1] * problem.cutoff_hz, 0.48 * rate)
    size = max(16, 2 * round(0.5 * SEGMENT_S * rate))
    if high < WIDE_ENOUGH * low or torque.size < 8 * size:
        return None
    power, frequency = _powers(torque, np.ones(torque.size, bool), size), np.fft.rfftfreq(size, 1.0 / rate)
    inside = (frequency >= low) & (frequency <= high)
    level = float(np.median(np.quantile(power[:, inside], QUANTILE, axis=0))) / -math.log(1.0 - QUANTILE)
    passed = lowpass_response(np.linspace(0.0, 0.5 * rate, 4000), problem.cutoff_hz) ** 2
    return math.sqrt(level * float(np.mean(passed)))


def position_noise(problem: FitProblem) -> float:
    """Standard deviation, rad, of what is white in the recorded motor position: an encoder's rounding and noise."""
    return _white_noise(problem, "motor_position", problem.recording.motor_position)


def torque_noise(problem: FitProblem) -> float:
    """Standard deviation, N m, of what is white in the recorded torque.

    From its spectrum above the motion, to which steps add, or from its third differences, to which fast motion adds.
    """
    torque = problem.recording.motor_torque
    rough = float(np.median(np.abs(np.diff(torque, 3)))) / (0.6745 * math.sqrt(20.0))
    return min(rough, _white_noise(problem, "motor_torque", torque))


def error_at_reversals(problem: FitProblem) -> float:
    """Root mean square, rad, of what the low-pass changes of the motor's position within `AROUND` samples of reversals.

    There the motion has a kink, which no low-pass follows.
    """
    motion = problem.motion
    turns = np.flatnonzero(motion.velocity[:-1] * motion.velocity[1:] <= 0.0)
    near = np.zeros(motion.velocity.size, bool)
    near[turns] = True
    near = ndimage.binary_dilation(near, iterations=AROUND)
    if not near.any():
        return 0.0
    return float(np.sqrt(np.mean((problem.recording.motor_position - motion.position)[near] ** 2)))


def link_noise(problem: FitProblem) -> float:
    """Root mean square, rad, of the link encoder's white noise in the compared link position.

    Above the band a link hardly moves, however much the motor does.
    """
    position, rate = problem.recording.link_position, problem.recording.sample_rate_hz
    if position is None:
        return 0.0
    passed = lowpass_response(np.linspace(0.0, 0.5 * rate, 4000), problem.cutoff_hz) ** 2
    white = _white_noise(problem, "link_position", position, moving_hz=problem.cutoff_hz)
    return white * math.sqrt(float(np.mean(passed)))


def _white_noise(problem: FitProblem, role: Role, signal: Floats, *, moving_hz: float | None = None) -> float:
    """From a signal's spectrum above the motion, which ends at `moving_hz`, or where the drive's does; where the rate
    leaves no room there, of the rounding alone.

    The steps are those of the signal as it was recorded, where that is known: stamps that jitter by 3 microseconds had
    left none at 250 Hz, and a link encoder without noise.
    """
    rate = problem.recording.sample_rate_hz
    low, high = max(HIGHEST[0] * rate, ABOVE[0] * (moving_hz or problem.drive_hz)), HIGHEST[1] * rate
    size = max(16, 2 * round(0.5 * SEGMENT_S * rate))
    if high < WIDE_ENOUGH * low or signal.size < 8 * size:
        recorded = (s.step for s in problem.recording.sampling if s.role == role)
        return max(resolution(signal), *recorded, 0.0) / math.sqrt(12.0)
    power, frequency = _powers(signal, np.ones(signal.size, bool), size), np.fft.rfftfreq(size, 1.0 / rate)
    inside = (frequency >= low) & (frequency <= high)
    return math.sqrt(float(np.median(np.quantile(power[:, inside], QUANTILE, axis=0))) / -math.log(1.0 - QUANTILE))


def encoder_noise(problem: FitProblem, values: Values) -> tuple[Floats, ...]:
    """What noise of the motor's encoder as the recording holds it does to each compared signal (m,).

    A spring that rings long makes much of little at the locked-motor frequency, in a narrow band and now more, now
    less: the steady part of what is left does not show that.
    """
    shaken = problem.shaken(position_noise).prediction(values)
    here = problem.prediction(values)
    pairs = [(shaken.torque, here.torque)]
    if shaken.link is not None and here.link is not None:
        pairs.append((shaken.link, here.link))
    return tuple(np.nan_to_num(one - other) for one, other in pairs)


def is_quiet(problem: FitProblem, steady: float) -> bool:
    """Whether at each frequency a third of the recording holds no motion, so that the steady part, N m rms, of what a
    model leaves is noise: the torque's own steady part is then no larger."""
    return noise_floor(problem.torque, problem.usable, problem.rate_hz) < QUIET_RATIO * steady


def _powers(signal: Floats, usable: NDArray[np.bool_], size: int) -> Floats:
    """Power (k, size // 2 + 1) of half-overlapping segments, unit^2, such that white noise has its variance."""
    size = min(size, signal.size // 2 * 2)
    window = np.hanning(size + 1)[:-1]
    starts = [s for s in range(0, signal.size - size + 1, size // 2) if usable[s : s + size].all()]
    if len(starts) < 6:
        starts = list(range(0, signal.size - size + 1, size // 2))
    segments = np.stack([signal[s : s + size] for s in starts])
    power: Floats = np.abs(np.fft.rfft(segments * window, axis=1)) ** 2 / np.sum(window**2)
    return power
