"""The band of frequencies in which a recording says something about the joint."""

from __future__ import annotations

import numpy as np
from scipy import signal

from flex_ident.recording import Floats, Recording

MIN_COHERENCE = 0.6
ENERGY_SHARE = 0.995


def excited_band_hz(recording: Recording) -> float:
    """The highest frequency, Hz, at which motor torque and motor position move together.

    Coherence of Welch's method over four-second segments: where nothing is excited, noise of many segments averages
    to a low coherence; where a chirp passed, torque and position are coherent. Feedback makes noise coherent too, so
    that the band ends at the latest at 1.5 times the frequency below which nearly all of the torque's energy lies,
    and at 0.4 of the sampling rate.
    """
    rate = recording.sample_rate_hz
    n = recording.motor_position.size
    segment = int(min(n // 8, 4.0 * rate))
    velocity = np.diff(recording.motor_position)
    frequency, coherence = signal.coherence(recording.motor_torque[1:], velocity, rate, nperseg=max(segment, 16))
    smooth: Floats = signal.medfilt(coherence, 9) if coherence.size > 9 else coherence
    energy = np.cumsum(np.abs(np.fft.rfft(recording.motor_torque - recording.motor_torque.mean())) ** 2)
    most = float(np.searchsorted(energy, ENERGY_SHARE * energy[-1])) * rate / n
    limit = min(0.4 * rate, max(1.5 * most, 12.0 * frequency[1]))
    coherent = (smooth > MIN_COHERENCE) & (frequency <= limit)
    # From the lowest frequency up to the first wide hole: lone coherent lines far above are not excitation.
    top = 0.0
    hole = max(1.0, 0.02 * rate)
    for f in frequency[coherent]:
        if f - top > max(hole, 0.5 * top) and top > 0.0:
            break
        top = float(f)
    return float(min(max(top, 8.0 * frequency[1]), limit))
