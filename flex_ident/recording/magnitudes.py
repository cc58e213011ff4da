"""Warnings about values that cannot be in SI units on the link side: degrees, millimetres, counts, raw drive units.

A torque constant that is off changes every parameter by the same factor and nothing else: only what no robot joint
can do is named here, so that a warning is worth reading.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flex_ident.notices import Code, Notice
from flex_ident.recording.recording import Floats, Recording

FASTEST = 20.0
"""rad/s or m/s: no joint that swings more than a turn does it faster on the link side."""
SPEED_WINDOW_S = 0.02
DISTINCT = 100
"""Different values from which numbers without fractions are counts, and not a coarse signal."""
LOW_SHARE = 0.1
"""Share of the motion, at its lowest frequencies, over which motor and link go together."""
SLOW_SAMPLES = 1 << 16
TOGETHER = 3.0
"""Ratio of motor to link motion, at low frequency, from which their units differ."""
LIGHTEST, HEAVIEST = 1e-6, 1e7
"""Bounds, kg m^2 or kg, on the inertia that effort and acceleration may suggest."""


def magnitude_notices(recording: Recording) -> tuple[Notice, ...]:
    """`position_not_si` and `effort_not_si`, where the recording's magnitudes cannot be SI; none where they can."""
    found = _position_complaint(recording) or _effort_complaint(recording)
    return () if found is None else (found,)


def _position_complaint(recording: Recording) -> Notice | None:
    for name, values in (("motor", recording.motor_position), ("link", recording.link_position)):
        if values is None:
            continue
        swing, speed = float(np.ptp(values)), _speed(values, recording.sample_rate_hz)
        if _are_counts(values) and swing > 2.0 * math.pi:
            return Notice(Code.POSITION_NOT_SI, f"{name}_position", {"swing": swing}, {"case": "counts", "which": name})
        if swing > 2.0 * math.pi and speed > FASTEST:
            moved = {"swing": swing, "speed": speed}
            return Notice(Code.POSITION_NOT_SI, f"{name}_position", moved, {"case": "swing", "which": name})
    ratio = _motor_over_link(recording)
    if ratio is not None and not 1.0 / TOGETHER < ratio < TOGETHER:
        return Notice(Code.POSITION_NOT_SI, "motor_position", {"ratio": ratio}, {"case": "ratio"})
    return None


def _effort_complaint(recording: Recording) -> Notice | None:
    torque = recording.motor_torque
    largest = float(np.abs(torque).max(initial=0.0))
    if _are_counts(torque):
        return Notice(Code.EFFORT_NOT_SI, "motor_torque", {"largest": largest}, {"case": "counts"})
    inertia = _apparent_inertia(recording)
    if inertia is not None and not LIGHTEST < inertia < HEAVIEST:
        sizes = {"largest": largest, "inertia": inertia}
        return Notice(Code.EFFORT_NOT_SI, "motor_torque", sizes, {"case": "inertia"})
    return None


def _speed(values: Floats, rate_hz: float) -> float:
    """Largest speed over a window long enough to leave out the noise of single samples."""
    window = max(1, round(SPEED_WINDOW_S * rate_hz))
    if values.size <= window:
        return 0.0
    return float(np.quantile(np.abs(values[window:] - values[:-window]), 0.99)) * rate_hz / window


def _are_counts(values: Floats) -> bool:
    """Whether a signal has no fractions, though it takes many values."""
    if bool((values[:DISTINCT] % 1.0).any()) or bool((values % 1.0).any()):
        return False
    return np.unique(values).size >= DISTINCT


def _motor_over_link(recording: Recording) -> float | None:
    """How many times as far the motor moves as the link, at the lowest frequencies that hold a share of its motion.

    Below every resonance the two move as one; above it they oppose each other, and nothing is said (None).
    """
    if recording.link_position is None:
        return None
    motor, link = (_slow_spectrum(q) for q in (recording.motor_position, recording.link_position))
    energy = np.cumsum(np.abs(motor) ** 2)
    low = slice(0, int(np.searchsorted(energy, LOW_SHARE * energy[-1])) + 1)
    cross = complex(np.vdot(motor[low], link[low]))
    both = float(energy[low][-1]) * float(np.sum(np.abs(link[low]) ** 2))
    if both == 0.0 or cross.real <= 0.0 or abs(cross) ** 2 < 0.8 * both:
        return None
    return float(energy[low][-1]) / cross.real


def _slow_spectrum(values: Floats) -> NDArray[np.complex128]:
    """Spectrum of a signal's slow part: of a long one, the means of neighbouring samples."""
    block = max(1, values.size // SLOW_SAMPLES)
    means = values[: values.size // block * block].reshape(-1, block).mean(axis=1)
    return np.fft.rfft(np.hanning(means.size) * (means - means.mean()))


def _apparent_inertia(recording: Recording) -> float | None:
    """Spread of effort over spread of acceleration, both without their fastest part."""
    window = max(1, round(SPEED_WINDOW_S * recording.sample_rate_hz))
    q = recording.motor_position
    if q.size <= 4 * window:
        return None
    acceleration = (q[2 * window :] - 2.0 * q[window:-window] + q[: -2 * window]) * (
        recording.sample_rate_hz / window
    ) ** 2
    spread = float(np.std(acceleration))
    return float(np.std(recording.motor_torque)) / spread if spread > 0.0 else None
