"""The even grid behind a signal's sample times: its period, and which of its samples were lost.

A late sample is not a lost one: after it, time is back on the grid. After a loss, it stays behind.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording.recording import Floats

WINDOW = 64
"""Samples within which one at least is on time."""
LONG = 1024
"""Samples over which irregular steps average out."""
LONG_GAP_PERIODS = 200.0
"""Gap over which lost samples cannot be counted for certain: a receive clock is laid anew behind it."""
REFINEMENTS = 2
CERTAIN = 0.3
"""Deviation of a step from whole periods up to which there is nothing to weigh."""
BURST = 0.7
"""Ratio of usual step to slope from below which messages arrive in bursts."""
REGULAR = 0.15
"""Deviation from the median, of it, within which most steps of a regular clock lie."""


def rough_period(time: Floats) -> float:
    """The sampling period, s: median of the steps, or of the slope over many where steps are anything but equal."""
    steps = np.diff(time)
    median = float(np.median(steps))
    span = min(LONG, max(1, steps.size // 8))
    slope = float(np.median(time[span:] - time[:-span])) / span
    regular = float(np.mean(np.abs(steps - median) < REGULAR * median)) > 0.5
    return median if regular and median > BURST * slope else slope


def grid_index(time: Floats, period: float) -> NDArray[np.int64]:
    """Place (n,) of each sample on its even grid of `period`, s, lost ones counted."""
    steps = np.diff(time) / period
    whole = np.rint(steps)
    if bool((whole >= 1.0).all()) and float(np.max(np.abs(steps - whole), initial=0.0)) < CERTAIN:
        return np.concatenate((np.zeros(1, np.int64), np.cumsum(whole.astype(np.int64))))
    late = time / period - np.arange(time.size)
    edges = np.append(np.arange(0, time.size, min(WINDOW, max(8, time.size // 8))), time.size)
    soonest = np.minimum.reduceat(late, edges[:-1])
    levels = _lost_before(soonest)
    lost = np.repeat(levels, np.diff(edges))
    for i in np.flatnonzero(np.diff(levels)).tolist():
        window = slice(edges[i], edges[i + 1])
        to_come = np.minimum.accumulate(late[window][::-1])[::-1] - soonest[i]
        lost[window] += np.clip(np.rint(to_come), 0, levels[i + 1] - levels[i]).astype(np.int64)
    return np.arange(time.size) + lost


def _lost_before(soonest: Floats) -> NDArray[np.int64]:
    """Samples lost before each window (k,), from the lateness of its soonest sample, in periods.

    Lateness that goes away again was a stall.
    """
    levels = np.zeros(soonest.size, np.int64)
    level, usual = 0, float(soonest[0])
    for i, now in enumerate(soonest.tolist()):
        level += round(now - level - usual)
        usual = now - level
        levels[i] = level
    certain: NDArray[np.int64] = np.minimum.accumulate(levels[::-1])[::-1]
    certain -= certain[0]
    return certain


def period_of(time: Floats, rough: float | None = None) -> float:
    """The sampling period, s: the slope of time over the count of samples, lost ones counted; `rough` is a guess."""
    rough = period = rough_period(time) if rough is None else rough
    for _ in range(REFINEMENTS):
        period = _line(grid_index(time, period), time)[0]
    # A clock can be so irregular that losses are miscounted; then the rough period is all there is.
    return period if abs(period / rough - 1.0) < 0.05 else rough


def evened(time: Floats, rough: float | None = None) -> Floats:
    """The instants at which samples received at `time` (n,) were taken: evenly spaced, lost ones counted.

    Times of which even the soonest stray over half a period from an even grid are given back as they are. `rough` is
    a guess of the period, s.
    """
    period = period_of(time, rough)
    even = np.array(time)
    edges = [0, *(np.flatnonzero(np.diff(time) > LONG_GAP_PERIODS * period) + 1).tolist(), time.size]
    for start, stop in pairwise(edges):
        if stop - start < WINDOW:
            continue
        own = time[start:stop]
        index = grid_index(own, period)
        slope, offset = _line(index, own)
        line = slope * index + offset
        late = own - line
        soonest = late[: late.size // WINDOW * WINDOW].reshape(-1, WINDOW).min(axis=1)
        if float(np.median(np.abs(soonest - np.median(soonest)))) > 0.5 * period:
            return time
        even[start:stop] = line + np.median(late)
    if not bool(np.all(np.diff(even) > 0)):
        return time
    return even


def _line(index: NDArray[np.int64], time: Floats) -> tuple[float, float]:
    """Slope and offset of time over index, least squares."""
    x, y = index - index.mean(), time - time.mean()
    slope = float(x @ y) / float(x @ x)
    return slope, float(time.mean() - slope * index.mean())
