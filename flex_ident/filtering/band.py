"""The band of frequencies in which a recording says something about the joint."""

from __future__ import annotations

import numpy as np
from scipy import ndimage, signal

from flex_ident.filtering.thresholds import (
    ENERGY_SHARE,
    LINE_COHERENCE,
    LINE_POWER,
    MIN_COHERENCE,
    RESOLVED,
    ROUNDED_SHARE,
)
from flex_ident.recording import Floats, Recording

AROUND = 9
"""Bins over which coherence is smoothed, and around which a line is looked for."""


def excited_band_hz(recording: Recording) -> float:
    """The highest frequency, Hz, at which motor torque and motor position move together.

    Coherence of Welch's method over four-second segments: where nothing is excited, noise of many segments averages
    to a low coherence; where a chirp passed, torque and position are coherent, and so they are at the lines of a
    multisine, which stand out of the torque's spectrum. Feedback makes noise coherent too, so
    that the band ends at the latest at 1.5 times the frequency below which nearly all of the torque's energy lies,
    and at 0.4 of the sampling rate; and where the encoder no longer resolves the motion: what a fast controller makes
    of its rounding is no torque that belongs to it.
    """
    rate = recording.sample_rate_hz
    n = recording.motor_position.size
    segment = int(min(n // 8, 4.0 * rate))
    velocity = np.diff(recording.motor_position)
    frequency, coherence = signal.coherence(recording.motor_torque[1:], velocity, rate, nperseg=max(segment, 16))
    smooth: Floats = signal.medfilt(coherence, AROUND) if coherence.size > AROUND else coherence
    _, power = signal.welch(recording.motor_torque[1:], rate, nperseg=max(segment, 16))
    line = (coherence > LINE_COHERENCE) & (power > LINE_POWER * ndimage.percentile_filter(power, 30, 2 * AROUND + 1))
    energy = np.cumsum(np.abs(np.fft.rfft(recording.motor_torque - recording.motor_torque.mean())) ** 2)
    most = float(np.searchsorted(energy, ENERGY_SHARE * energy[-1])) * rate / n
    limit = min(0.4 * rate, max(1.5 * most, 12.0 * frequency[1]), resolved_band_hz(recording))
    coherent = ((smooth > MIN_COHERENCE) | line) & (frequency <= limit)
    # From the lowest frequency up to the first wide hole: lone coherent lines far above are not excitation.
    top = 0.0
    hole = max(1.0, 0.02 * rate)
    for f, stands_out in zip(frequency[coherent], line[coherent], strict=True):
        if f - top > max(hole, (2.0 if stands_out else 0.5) * top) and top > 0.0:
            break
        top = float(f)
    return float(min(max(top, 8.0 * frequency[1]), limit))


def resolved_band_hz(recording: Recording) -> float:
    """The highest frequency, Hz, at which the motion rises above the rounding of its encoder; half the rate at most.

    An encoder's rounding is white noise of a twelfth of its squared step. A position that is not rounded has no limit.
    """
    position, rate = recording.motor_position, recording.sample_rate_hz
    steps = np.abs(np.diff(position))
    smallest = float(np.min(steps[steps > 1e-9 * (np.ptp(position) or 1.0)], initial=np.inf))
    whole = steps / smallest if np.isfinite(smallest) else steps
    if not np.isfinite(smallest) or float(np.mean(np.abs(whole - np.round(whole)) < 0.01)) < ROUNDED_SHARE:
        return 0.5 * rate
    segment = int(max(16, min(position.size // 4, 4.0 * rate)))
    frequency, power = signal.welch(position, rate, nperseg=segment, detrend="linear")
    floor = smallest**2 / 12.0 / (0.5 * rate)
    above = frequency[ndimage.maximum_filter1d(power, 5) > RESOLVED * floor]
    return float(above[-1]) if above.size else 0.5 * rate
