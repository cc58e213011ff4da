"""Values that stand alone: zeros that a driver or a second publisher puts in between, and spikes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from flex_ident.recording.noise import NEAR, resolution, roughness, usual_change, without_rounding
from flex_ident.recording.recording import Floats

FEWEST = 32
LONGEST_RUN = 4
"""Equal values in a row up to which they stand alone."""
REPEATED, CANDIDATES = 5, 4
"""How often an outlier must have the same value to be a constant put in between, and how many such are looked at."""
SCATTER, STEPS = 8.0, 3.0
"""How far, in the scatter around it and in steps of the resolution, a value that recurs must lie off its neighbours."""
LEAST_OF_ZEROS, LEAST_OF_OTHERS = 0.02, 0.5
"""Share of the places where a constant stands at which it must lie off its neighbours."""
SPIKE_ROUGH, CHANGES = 20.0, 4.0
"""The same for a spike, which has nothing but its size against it, in the roughness around it and usual changes."""
SPIKE_SHARE, POSITION_SHARE = 0.5, 0.02
"""How far a spike must lie off its neighbours, in the range of nearly all values: a position cannot jump, a torque can.
With a quarter, the feedforward of a computed torque under steps passed for spikes (`bench/plants`, 1 of 70)."""
LONGEST_SPIKE = 3
"""Samples in a row up to which values far off to the same side are spikes."""
NEARLY_ALL = (0.01, 0.99)
MOST_SPIKES = 0.02
"""Share of the samples from which what stands out is no spike but the signal."""


def put_in_between(values: Floats) -> tuple[NDArray[np.bool_], float]:
    """Which (n,) values are one constant, zero before any other, that stands off its neighbours; and that constant.

    A quantised signal that passes a value, or rests at it, comes there step by step: its neighbours are close.
    """
    none = np.zeros(values.size, bool)
    if values.size < FEWEST:
        return none, 0.0
    values = without_rounding(values)
    excursion, enough = _excursions(values)
    levels, counts = np.unique(values[1:-1][excursion > enough], return_counts=True)
    most = np.argsort(counts)[: -1 - CANDIDATES : -1]
    often = [float(levels[i]) for i in most if counts[i] >= REPEATED and levels[i] != 0.0]
    for constant in (0.0, *often):
        off = _alone(values, constant)
        if off.any():
            return off, constant
    return none, 0.0


def _alone(values: Floats, constant: float) -> NDArray[np.bool_]:
    """Which (n,) values are `constant`, alone or in short runs, where their neighbours say something else.

    None, unless a good part of the places where the constant stands are such.
    """
    found = np.zeros(values.size, bool)
    equal = values == constant
    edges = np.flatnonzero(np.diff(np.concatenate(([False], equal, [False])).astype(np.int8)))
    starts, lengths = edges[::2], edges[1::2] - edges[::2]
    starts, lengths = starts[lengths <= LONGEST_RUN], lengths[lengths <= LONGEST_RUN]
    inserted = np.zeros(values.size, bool)
    for i in range(LONGEST_RUN):
        inserted[starts[lengths > i] + i] = True
    others = values[~inserted]
    if not starts.size or others.size < FEWEST:
        return found
    before = np.cumsum(~inserted)[starts]
    inside = (before >= 2) & (before + 2 <= others.size)
    starts, lengths, before = starts[inside], lengths[inside], before[inside]
    near = [others[before + i] for i in (-2, -1, 0, 1)]
    due = np.where(lengths == 1, (4.0 * (near[1] + near[2]) - near[0] - near[3]) / 6.0, 0.5 * (near[1] + near[2]))
    scatter = _scatter(others)[before]
    off = (near[1] - constant) * (near[2] - constant) > 0.0
    off &= np.abs(due - constant) > SCATTER * scatter + STEPS * resolution(others)
    least = LEAST_OF_ZEROS if constant == 0.0 else LEAST_OF_OTHERS
    if not off.any() or lengths[off].sum() < least * np.count_nonzero(equal):
        return found
    for start, length in zip(starts[off].tolist(), lengths[off].tolist(), strict=True):
        found[start : start + length] = True
    return found


def _scatter(values: Floats) -> Floats:
    """Median deviation (n,) of the values around each from the cubic through two neighbours on either side."""
    due = (4.0 * (values[1:-3] + values[3:-1]) - values[:-4] - values[4:]) / 6.0
    off = np.abs(values[2:-2] - due)
    near: Floats = ndimage.median_filter(np.pad(off, 2, mode="edge"), min(NEAR, off.size), mode="mirror")
    return near


def spikes(values: Floats, role: str = "motor_torque") -> NDArray[np.bool_]:
    """Which (n,) values lie far off both neighbours, to the same side, alone or a few in a row."""
    found = np.zeros(values.size, bool)
    if values.size < FEWEST:
        return found
    low, high = np.quantile(values, NEARLY_ALL)
    rough, usual = roughness(values), usual_change(values)
    # Where a signal rests it may be smooth; what moves next is no spike for that.
    enough = SPIKE_ROUGH * np.maximum(rough, float(np.median(rough))) + CHANGES * usual
    for length in range(1, LONGEST_SPIKE + 1):
        share = SPIKE_SHARE if role == "motor_torque" else POSITION_SHARE
        found |= _far_runs(values, np.maximum(enough, share * (high - low)), length)
    if np.count_nonzero(found) > MOST_SPIKES * values.size:
        found[:] = False
    return found


def _far_runs(values: Floats, enough: Floats, length: int) -> NDArray[np.bool_]:
    """Which (n,) values are of `length` in a row that all lie off the values before and behind them by `enough`."""
    n = values.size
    found = np.zeros(n, bool)
    before, behind = values[: n - length - 1], values[length + 1 :]
    inner = [values[1 + i : n - length + i] for i in range(length)]
    top, bottom = np.maximum(before, behind), np.minimum(before, behind)
    off = np.maximum(np.minimum.reduce(inner) - top, bottom - np.maximum.reduce(inner))
    starts = 1 + np.flatnonzero(off > enough[1 : n - length])
    for i in range(length):
        found[starts + i] = True
    return found


def _excursions(values: Floats) -> tuple[Floats, Floats]:
    """How far (n - 2,) each inner value lies off both neighbours to one side, and what is clearly too far (n - 2,)."""
    left, right = values[1:-1] - values[:-2], values[1:-1] - values[2:]
    off = np.where(left * right > 0.0, np.minimum(np.abs(left), np.abs(right)), 0.0)
    return off, SPIKE_ROUGH * roughness(values)[1:-1] + CHANGES * usual_change(values)
