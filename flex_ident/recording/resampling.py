"""One signal's values at the instants of a uniform clock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate, signal

from flex_ident.recording.instants import period_of
from flex_ident.recording.recording import Floats

UNIFORM = 1e-3
"""Jitter, in periods, below which samples are taken as they stand."""
GAP_PERIODS = 5.0
"""Length of a gap, in periods, from which the bridge over it carries no information."""
CLOSEST = 0.2
"""Distance to the sample before, in periods, below which one adds noise to a spline and nothing else."""
PIECE = 1 << 16
OVERLAP = 64
"""Samples on either side of a piece; a cubic spline forgets at 0.27 a sample."""
FASTER = 1.5
"""Ratio of rates from which a signal is low-passed before it is sampled at the clock's."""
MOSTLY_GAPS = 16
"""Instants of its own grid for each sample from which a signal is so full of gaps that it is not low-passed."""
EDGE, TAPS = 0.4, 20
"""Edge of that low-pass, of the clock's rate, and its length, in the clock's periods."""


def on_clock(time: Floats, values: Floats, clock: Floats, period: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Values (n,) of a signal at the instants `clock` (n,), and where (n,) they rest on samples close by.

    Samples on the clock are taken as they stand; others by cubic splines; a signal of a much higher rate is low-passed
    first, without delay. Gaps are bridged by straight lines. `period`, s, is the clock's.
    """
    measured = np.ones(clock.size, bool)
    first = int(np.argmin(np.abs(time - clock[0])))
    direct = time[first : first + clock.size]
    if direct.size == clock.size and float(np.max(np.abs(direct - clock))) < UNIFORM * period:
        return values[first : first + clock.size], measured
    own_period = period_of(time)
    widest = GAP_PERIODS * max(own_period, period)
    apart = np.diff(time, prepend=-np.inf) > CLOSEST * own_period
    time, values = time[apart], values[apart]
    resampled, inside = _bridged(time, values, clock, widest)
    if own_period * FASTER < period:
        resampled = spline(*_slowed(time, values, own_period, period), clock)
    measured[inside] = False
    return resampled, measured


def _bridged(time: Floats, values: Floats, clock: Floats, widest: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Splined values (n,), on straight lines in gaps of over `widest`, s, and which (n,) those are."""
    resampled = spline(time, values, clock)
    inside = np.zeros(clock.size, bool)
    gaps = np.flatnonzero(np.diff(time) > widest)
    if gaps.size:
        left = np.searchsorted(time, clock, side="right") - 1
        inside = np.isin(left, gaps) & (clock > time[np.maximum(left, 0)])
        resampled[inside] = np.interp(clock[inside], time, values)
    return resampled, inside


def spline(time: Floats, values: Floats, clock: Floats) -> Floats:
    """Values (n,) at the increasing instants `clock` (n,) of cubic splines, piece by piece to save memory."""
    resampled = np.empty(clock.size)
    for start in range(0, clock.size, PIECE):
        part = clock[start : start + PIECE]
        low = max(0, int(np.searchsorted(time, part[0])) - OVERLAP)
        high = int(np.searchsorted(time, part[-1])) + OVERLAP
        resampled[start : start + PIECE] = interpolate.CubicSpline(time[low:high], values[low:high])(part)
    return resampled


def _slowed(time: Floats, values: Floats, own_period: float, period: float) -> tuple[Floats, Floats]:
    """The signal on an even grid of its own period, without what the slower clock would alias."""
    taps = int(TAPS * period / own_period) // 2 * 2 + 1
    instants = (time[-1] - time[0]) / own_period
    if not taps < instants < MOSTLY_GAPS * time.size:
        return time, values
    even: Floats = np.arange(time[0], time[-1], own_period)
    kernel = signal.firwin(taps, EDGE / period, fs=1.0 / own_period)
    bridged, _ = _bridged(time, values, even, GAP_PERIODS * own_period)
    padded = np.pad(bridged, taps // 2, mode="reflect", reflect_type="odd")
    return even, signal.oaconvolve(padded, kernel, mode="valid")
