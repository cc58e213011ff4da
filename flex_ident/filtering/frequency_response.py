"""Apparent inertia over frequency, and the first mode in it.

Torque over motor acceleration is Jm + JL far below the modes, has its peak at the locked-motor frequency sqrt(K / JL),
its dip at the free resonance, and is Jm far above.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flex_ident.filtering.band import excited_band_hz
from flex_ident.filtering.spectral import SpectralFilter
from flex_ident.parameters import FrequencyResponse
from flex_ident.recording import Floats, Recording

Complex = NDArray[np.complex128]
BINS = 160
DAMPING_RATIOS = (0.01, 0.03, 0.1, 0.3)


@dataclass(frozen=True)
class FirstMode:
    """The locked-motor frequency, Hz, and the free resonance, with a confidence from 0 to 1 and its reason."""

    frequency_hz: float
    free_resonance_hz: float
    confidence: float
    text: str
    response: FrequencyResponse


def apparent_inertia(recording: Recording, band_hz: float) -> tuple[Floats, Complex, Floats]:
    """Frequency (m,), Hz, torque over motor acceleration (m,), and coherence (m,), in logarithmic bins."""
    rate = recording.sample_rate_hz
    n = recording.motor_position.size
    smooth = SpectralFilter(n, rate, min(3.0 * band_hz, 0.45 * rate))
    (acceleration,) = smooth(recording.motor_position, (2,))
    (torque,) = smooth(recording.motor_torque)
    window = np.ones(n)
    taper = min(n // 10, int(rate))
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(taper) / taper)
    window[:taper], window[n - taper :] = ramp, ramp[::-1]
    a = np.fft.rfft(window * acceleration)
    y = np.fft.rfft(window * (torque - torque.mean()))
    frequency = np.fft.rfftfreq(n, 1.0 / rate)
    low = max(0.1, 6.0 * rate / n)
    edges = np.geomspace(low, max(band_hz, 2.0 * low), BINS + 1)
    index = np.digitize(frequency, edges) - 1
    inside = (index >= 0) & (index < BINS)
    index = index[inside]

    def summed(values: Complex) -> Complex:
        real = np.bincount(index, values[inside].real, BINS)
        return real + 1j * np.bincount(index, values[inside].imag, BINS)

    cross, auto = summed(y * a.conj()), summed((a * a.conj()).astype(complex)).real
    power = summed((y * y.conj()).astype(complex)).real
    count = np.bincount(index, minlength=BINS)
    good = (auto > 0) & (power > 0) & (count >= 3)
    centre: Floats = np.sqrt(edges[:-1] * edges[1:])[good]
    coherence: Floats = (np.abs(cross[good]) ** 2 / (auto[good] * power[good])).astype(np.float64)
    return centre, cross[good] / auto[good], coherence


def first_mode(recording: Recording, *, hint_hz: float | None = None) -> FirstMode:
    """The first mode of a recording, from its apparent inertia; never raises for want of a mode.

    For each frequency and damping of a grid Jm, JL and viscous friction are linear in the apparent inertia; the
    confidence compares the best fit with that of a rigid joint.
    """
    band = excited_band_hz(recording)
    frequency, inertia, coherence = apparent_inertia(recording, band)
    response = FrequencyResponse("apparent inertia: motor torque over motor acceleration", frequency,
                                 np.abs(inertia), coherence)  # fmt: skip
    if frequency.size < 12:
        return FirstMode(math.nan, math.nan, 0.0, "too little is excited to see a mode", response)
    omega = 2.0 * np.pi * frequency
    # Relative weights: each octave counts alike, the resonance's neighbourhood not more than the rest.
    weight = coherence / np.abs(inertia)
    friction = 1.0 / (1j * omega)
    grid = np.geomspace(2.0 * frequency[0], 1.2 * frequency[-1], 220)
    if hint_hz is not None:
        grid = hint_hz * np.geomspace(0.8, 1.25, 60)
    rigid_cost, _ = _linear_cost([np.ones_like(friction), friction], inertia, weight)
    best = (math.inf, math.nan, math.nan)
    for f in grid:
        locked = 2.0 * np.pi * f
        for damping in DAMPING_RATIOS:
            pole = (locked**2 + 2j * damping * locked * omega) / (locked**2 - omega**2 + 2j * damping * locked * omega)
            cost, solution = _linear_cost([np.ones_like(friction), friction, pole], inertia, weight)
            if solution[0] > 0 and solution[2] > 0 and cost < best[0]:
                best = (cost, float(f), float(f * math.sqrt(1.0 + solution[2] / solution[0])))
    cost, locked_hz, free_hz = best
    if not math.isfinite(locked_hz):
        return FirstMode(math.nan, math.nan, 0.0, f"no mode up to {band:.3g} Hz: the joint looks rigid there", response)
    gain = max(0.0, 1.0 - cost / rigid_cost)
    inside = 1.0 if locked_hz < 0.8 * band else (0.5 if locked_hz < band else 0.2)
    confidence = gain * inside
    text = f"the mode explains {100 * gain:.0f} % of what a rigid joint leaves open up to {band:.3g} Hz"
    if inside < 1.0:
        text += ", but lies at the edge of the excited band"
    return FirstMode(locked_hz, free_hz, confidence, text, replace(response, modes_hz=(locked_hz, free_hz)))


def _linear_cost(columns: list[NDArray[Any]], target: Complex, weight: Floats) -> tuple[float, Floats]:
    matrix = np.stack(columns, axis=1) * weight[:, None]
    goal = target * weight
    stacked = np.concatenate((matrix.real, matrix.imag))
    both = np.concatenate((goal.real, goal.imag))
    scale = np.linalg.norm(stacked, axis=0)
    scale[scale == 0.0] = 1.0
    solution, *_ = np.linalg.lstsq(stacked / scale, both, rcond=1e-10)
    cost = float(np.sum((both - (stacked / scale) @ solution) ** 2))
    return cost, solution / scale
