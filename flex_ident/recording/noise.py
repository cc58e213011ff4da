"""How rough a signal is from sample to sample, here and there: what a fault must stand out from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from flex_ident.recording.recording import Floats

NEAR = 31
"""Samples over which roughness is looked at."""
ROUNDING = 1e-9
"""Share of a signal's range that is rounding: differences below it are none."""
FINEST = 0.02
"""Quantile of a signal's changes taken for its resolution: of a quantised one, its step; of any other, next to none."""


def without_rounding(values: Floats) -> Floats:
    """The values (n,) on a grid of a billionth of their range: what differs by rounding is equal. Zero stays zero."""
    step = ROUNDING * float(np.ptp(values))
    return np.rint(values / step) * step if step > 0.0 else values


def usual_change(values: Floats) -> float:
    """Median size of the changes from sample to sample, repeats left out; 0 of a constant."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0.0]
    return float(np.median(steps)) if steps.size else 0.0


def resolution(values: Floats) -> float:
    """The step of a quantised signal; of one that is not, a small part of its noise; 0 of a constant."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0.0]
    return max(float(np.quantile(steps, FINEST)), 10.0 * ROUNDING * float(np.ptp(values))) if steps.size else 0.0


def roughness(values: Floats) -> Floats:
    """Median size (n,) of the second differences around each sample."""
    if values.size < 3:
        return np.zeros(values.size)
    second = np.abs(np.diff(values, 2))
    near: Floats = ndimage.median_filter(np.pad(second, 1, mode="edge"), min(NEAR, second.size), mode="mirror")
    return near


def runs_of_equal(values: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where each run of equal values begins (k,), and how long it is (k,)."""
    starts = np.flatnonzero(np.concatenate(([True], np.diff(values) != 0.0)))
    return starts, np.diff(np.append(starts, values.size))
