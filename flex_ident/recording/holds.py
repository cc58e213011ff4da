"""Signals that are stamped more often than they are measured, and efforts that stand still while the joint does not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording.instants import evened
from flex_ident.recording.noise import resolution, runs_of_equal, without_rounding
from flex_ident.recording.recording import Floats

WINDOW = 64
FAST = 10.0
"""Change from sample to sample, in steps of the resolution, between which repeats are not chance."""
FEWEST_CHANGES, FEWEST_WINDOWS = 100, 4
HELD = 0.12
"""Repeats for each such change from which the signal is held; by chance there are at most 0.05."""
SLOWEST = 100
"""Samples to an update, at most."""
PHASE = 0.97
"""Share of the changes, window by window, that must come at one phase of an update for coarse signals."""
CHANGES = 6
"""Changes in a window from which its phases say anything."""
STEP = 1.01
"""Steps of a quantised effort into and out of a stretch up to which it is the rounding that stands still."""
FROZEN_S, FROZEN_SAMPLES = 0.1, 20
LONGER, OTHERS = 5.0, 10
"""How much longer a run must be than this many other runs at least to be a freeze."""
MOVED = 0.02
"""Share of the position's range that the joint must stray from a steady speed within a freeze that lacks no noise."""
NOISY, NOISIEST = 0.6, 0.9
"""Share of the second differences that change sign from which a signal has noise, where it has most of it."""
ROUGHER = 3.0
"""Size of a second difference, in steps of the resolution, from which it is no rounding."""
WAITING = 0.05
"""Differences in the time that values wait for their message, in periods, from which they are worth correcting."""
SOONEST = 0.01
"""Quantile of that time at which a value waits for none."""
DISTINCT = 0.5
"""Share of the samples with a value of their own from which a signal is not quantised."""


def samples_per_update(values: Floats) -> float:
    """Samples from one measurement to the next of a signal that is held in between; 1 of one that is not.

    Repeats are counted only between changes that are far larger than the resolution: a quantised signal that rests or
    moves slowly repeats itself too, and so does one that is clipped, at its ends. Of a coarse signal, the changes must
    come at one phase of the update.
    """
    values = without_rounding(values)
    if values.size < WINDOW * FEWEST_WINDOWS or not np.ptp(values) > 0.0:
        return 1.0
    steps = np.abs(np.diff(values))
    changes = np.flatnonzero(steps)
    large = steps[changes] > FAST * resolution(values)
    repeats = np.diff(changes) - 1
    held = values[changes[:-1] + 1]
    counted = large[:-1] & large[1:] & (repeats < SLOWEST) & (held > np.min(values)) & (held < np.max(values))
    if np.count_nonzero(counted) >= FEWEST_CHANGES:
        mean = float(np.mean(repeats[counted]))
        return 1.0 + mean if mean > HELD else 1.0
    windows = steps[: steps.size // WINDOW * WINDOW].reshape(-1, WINDOW)
    return float(_update_by_phase(windows != 0.0))


def _update_by_phase(changed: NDArray[np.bool_]) -> int:
    """The largest count of samples to an update such that all changes in each window (k, WINDOW) come at one phase."""
    busy = changed[changed.sum(axis=1) >= CHANGES]
    if busy.shape[0] < FEWEST_WINDOWS:
        return 1
    for count in range(WINDOW // CHANGES, 1, -1):
        whole = WINDOW // count * count
        phases = busy[:, :whole].reshape(busy.shape[0], -1, count).sum(axis=1)
        total = phases.sum(axis=1)
        if float(np.mean(phases.max(axis=1) / np.maximum(total, 1))) > PHASE:
            return count
    return 1


def fresh(values: Floats, per_update: float) -> NDArray[np.bool_]:
    """Which (n,) samples are measurements: the first of each run of equal ones, and one an update in long runs."""
    starts, lengths = runs_of_equal(without_rounding(values))
    since = np.arange(values.size) - np.repeat(starts, lengths)
    every = int(np.ceil(per_update - HELD))
    kept: NDArray[np.bool_] = since % max(1, every) == 0
    return kept


def measured_at(time: Floats, period: float, values: Sequence[Floats]) -> Floats:
    """The instants (n,) at which held values were measured, where `time` (n,) is that of the first message of each.

    Measured every `period`, s, roughly. With a ratio of rates that is not whole, a value waits for its message between
    none and a whole message's time, the soonest for none; or it is measured with its message, and some messages get
    none. Those instants are taken in which the signals' `values` (n,) run more smoothly.
    """
    even = evened(time, period)
    age = time - even
    if not float(np.ptp(age)) > WAITING * period:
        return time
    at: Floats = even + float(np.quantile(age, SOONEST))
    smoother = sum(math.log(max(_unevenness(at, v), 1e-300) / max(_unevenness(time, v), 1e-300)) for v in values)
    return at if smoother < 0.0 else time


def _unevenness(time: Floats, values: Floats) -> float:
    """Mean size of the differences between values and the cubics through two neighbours on either side."""
    size = time.size - 4
    at, near = time[2:-2], [time[i : i + size] for i in (0, 1, 3, 4)]
    due = np.zeros(size)
    for i, index in enumerate((0, 1, 3, 4)):
        weight = np.ones(size)
        for j, other in enumerate(near):
            if j != i:
                weight *= (at - other) / (near[i] - other)
        due += weight * values[index : index + size]
    return float(np.mean(np.abs(values[2:-2] - due)))


@dataclass(frozen=True)
class Freeze:
    """A stretch of samples in which an effort stood still."""

    start: int
    stop: int


def freezes(effort: Floats, position: Floats, period: float) -> list[Freeze]:
    """Stretches in which the effort is one number, to the last bit, though it should not be.

    `position` (n,) is the joint's at the same samples. Stands out: a run that lasts 0.1 s and far longer than nearly
    all others, while the joint speeds up or slows down; or at rest, when the effort has noise everywhere else. A
    quantised effort may repeat itself while a joint rests or moves steadily, and where a step of it leads into the
    stretch and another out of it; one that is clipped rests at the same end of its range again and again.
    """
    effort = without_rounding(effort)
    starts, lengths = runs_of_equal(effort)
    usual = float(np.sort(lengths)[max(0, lengths.size - OTHERS)])
    long = lengths >= max(FROZEN_SAMPLES, FROZEN_S / period, LONGER * usual)
    if not long.any() or long.all():
        return []
    step = STEP * _smallest_step(effort)
    strayed, noisy = MOVED * float(np.ptp(position)), _has_noise(effort, starts[long], lengths[long])
    found = []
    clipped = [x for x in (np.min(effort), np.max(effort)) if np.count_nonzero(effort[starts[lengths > 1]] == x) > 1]
    for start, length in zip(starts[long].tolist(), lengths[long].tolist(), strict=True):
        if effort[start] in clipped:
            continue
        ends = effort[[max(start - 1, 0), min(start + length, effort.size - 1)]]
        if start + length < effort.size and float(np.max(np.abs(ends - effort[start]))) <= step:
            continue
        here, at = position[start : start + length], np.arange(length)
        steady = np.polyval(np.polyfit(at, here, 1), at)
        if noisy or float(np.max(np.abs(here - steady))) > strayed:
            found.append(Freeze(start, start + length))
    return found


def _smallest_step(values: Floats) -> float:
    """The least that a signal changes by where it changes; 0 of a constant."""
    steps = np.abs(np.diff(values))
    changes = steps[steps > 0.0]
    return float(np.min(changes)) if changes.size else 0.0


def _has_noise(effort: Floats, starts: NDArray[np.int64], lengths: NDArray[np.int64]) -> bool:
    """Whether the effort, outside of some stretches, is rough and hardly ever repeats a value."""
    outside = np.ones(effort.size, bool)
    for start, length in zip(starts.tolist(), lengths.tolist(), strict=True):
        outside[start : start + length] = False
    rest = effort[outside]
    if rest.size < WINDOW or np.unique(rest).size < DISTINCT * rest.size:
        return False
    second = np.diff(rest, 2)
    rough = np.abs(second) > ROUGHER * resolution(rest)
    turns = (second[1:] * second[:-1] < 0.0) & rough[1:] & rough[:-1]
    windows = turns[: turns.size // WINDOW * WINDOW].reshape(-1, WINDOW).mean(axis=1)
    return windows.size > 0 and float(np.quantile(windows, NOISIEST)) > NOISY
