"""Columns of the observation matrix W, filtered: the paper's way, and with clean preprocessing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from flex_ident.errors import ExcitationError
from flex_ident.filtering.derivatives import central_differences, decimated, zero_phase_lowpass
from flex_ident.filtering.design import FilterDesign
from flex_ident.filtering.spectral import SpectralFilter
from flex_ident.recording import Floats, Recording, extent_text, more_needed

GRAVITY = 9.81
Derivative = Callable[[Floats, int], Floats]


@dataclass(frozen=True)
class Observation:
    """How signals become rows: `derivative(signal, order)` (n,) and `reduced(columns)` (n, k) to (r, k).

    `sign` (n,) is the direction of a velocity; `time` (r,) the rows' instants.
    """

    derivative: Derivative
    sign: Callable[[Floats, Floats], Floats]
    reduced: Callable[[Floats], Floats]
    time: Floats


def paper_observation(recording: Recording, design: FilterDesign) -> Observation:
    """Section 3.2 of the paper to the letter: Butterworth forward and back, central differences, decimation.

    The signal as such (order 0) is low-passed as its derivatives are. Edges: two periods of the decimated clock, or
    what the differences need if that is more, are dropped at each end. Raises ExcitationError on too few samples.
    """
    rate = recording.sample_rate_hz
    n = recording.motor_position.size
    edge = max(2 * design.decimation, design.derivative_order + 1)
    if n < 6 * edge + 60:
        raise ExcitationError(
            f"{n} samples are too few for a decimation by {design.decimation}: record at least "
            f"{(6 * edge + 60) / rate:.0f} s."
        )

    def derivative(values: Floats, order: int) -> Floats:
        smooth = zero_phase_lowpass(values, design.cutoff_rad_s, design.order, rate)
        return central_differences(smooth, rate, order)

    def reduced(columns: Floats) -> Floats:
        return decimated(columns[edge : n - edge], design.decimation)

    time = recording.time[edge : n - edge][:: design.decimation]
    return Observation(derivative, lambda v, a: np.sign(v), reduced, time)


def clean_observation(recording: Recording, *, band_hz: float, trim_s: float = 1.0) -> Observation:
    """The same rows without the paper's distortions: exact derivatives, direction averaged over the sample.

    Every column is low-passed and decimated alike, to 1.2 times the band; the first and last second, gaps and
    standstill are dropped. Raises ExcitationError when too little is left.
    """
    rate = recording.sample_rate_hz
    n = recording.motor_position.size
    fine = SpectralFilter(n, rate, min(3.0 * band_hz, 0.45 * rate))
    coarse_hz = min(1.2 * band_hz, 0.45 * rate)
    coarse = SpectralFilter(n, rate, coarse_hz)
    keep = max(1, int(rate / (2.5 * coarse_hz)))
    trim = int(min(trim_s * rate, n / 10))
    usable = np.ones(n, bool)
    usable[:trim] = False
    usable[n - trim :] = False
    assert recording.measured is not None
    if not recording.measured.all():
        usable &= ~ndimage.binary_dilation(~recording.measured, iterations=max(1, int(rate / coarse_hz)))
    position, velocity = fine(recording.motor_position, (0, 1))
    noise = float(np.std((recording.motor_position - position)[10:-10]))
    resolution = max(2.0 * noise * 2.0 * np.pi * band_hz, 1e-9)
    moving = ndimage.uniform_filter1d((np.abs(velocity) > resolution).astype(float), max(3, int(0.1 * rate)))
    usable &= moving >= 0.5
    rows = usable[::keep]
    if int(rows.sum()) < 40:
        raise ExcitationError(
            f"{int(rows.sum())} usable samples are left of {extent_text(n, rate)} after filtering, edges, gaps and "
            f"standstill: {more_needed(n, rate)}"
        )

    def derivative(values: Floats, order: int) -> Floats:
        return fine(values, (order,))[0]

    def sign(v: Floats, a: Floats) -> Floats:
        width = np.maximum(0.5 * np.abs(a) / rate, resolution)
        averaged: Floats = np.clip(v / width, -1.0, 1.0)
        return averaged

    def reduced(columns: Floats) -> Floats:
        if columns.ndim == 1:
            return coarse(columns)[0][::keep][rows]
        return np.column_stack([coarse(c)[0][::keep][rows] for c in columns.T])

    return Observation(derivative, sign, reduced, recording.time[::keep][rows])
