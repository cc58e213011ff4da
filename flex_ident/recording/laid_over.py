"""Two stretches of one recording laid over each other: a clock that jumped back, sorted by time afterwards.

Where a clock jumps back by J at T, what came before and what comes behind share the times from T - J to T. A program
that sorts messages by time makes them take turns there: twice as many messages, and positions that go to and fro
between two motions. In the order of the bag such a jump is plain, and `cleaning.py` sees to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flex_ident.notices import Code, Notice
from flex_ident.recording.cleaning import measurable
from flex_ident.recording.raw import RawSignal
from flex_ident.recording.recording import Role

FEWEST = 400
"""Messages from which this is looked for."""
BIN = 20
"""Usual periods over which messages are counted."""
LEAST_BINS = 5
"""Counts in a row that must be twice the usual: shorter ones are messages that were held up and came at once."""
TWICE = (1.6, 2.4)
TO_AND_FRO = 1.0
"""Steps to the next message over steps to the one after it, in the median: half in one motion, more between two."""
AWAY = 0.6
"""The same outside, up to which positions are of one motion."""


def without_laid_over(raw: Mapping[Role, RawSignal]) -> tuple[dict[Role, RawSignal], list[Notice]]:
    """The signals' longest stretch beside one where two lie over each other, and what was done; else as they are."""
    motor = raw["motor_position"]
    found = _window(motor)
    if found is None:
        return dict(raw), []
    start, end = found
    before, after = int(np.count_nonzero(motor.received < start)), int(np.count_nonzero(motor.received > end))
    kept: dict[Role, RawSignal] = {}
    for role, own in raw.items():
        mask = own.received < start if before >= after else own.received > end
        kept[role] = replace(own, received=own.received[mask], stamps=own.stamps[mask], values=own.values[mask])
    total = motor.received.size
    sizes = {
        "jumps": 1.0, "largest_s": (end - start) * 1e-9, "at_s": (end - int(motor.received[0])) * 1e-9,
        "kept": float(max(before, after)), "dropped": float(total - max(before, after)),
    }  # fmt: skip
    return kept, [Notice(Code.TIME_JUMPED_BACK, motor.source.partition(":")[0], sizes)]


def _window(motor: RawSignal) -> tuple[int, int] | None:
    """From when to when, ns, two stretches take turns; None where there is no such time."""
    time, values = motor.received, motor.values
    if time.size < FEWEST or not bool(np.all(np.diff(time) >= 0)) or not bool(np.all(measurable(values))):
        return None
    width = BIN * float(np.percentile(np.diff(time), 75.0))
    if width <= 0.0 or (time[-1] - time[0]) / width > time.size:
        return None
    counts = np.bincount(((time - time[0]) / width).astype(np.int64))
    usual = float(np.percentile(counts[counts > 0], 25.0))
    twice = np.concatenate(([False], (counts > TWICE[0] * usual) & (counts < TWICE[1] * usual), [False]))
    edges = np.flatnonzero(np.diff(twice.astype(np.int8)))
    runs = edges.reshape(-1, 2)
    if not runs.size:
        return None
    first, last = runs[int(np.argmax(runs[:, 1] - runs[:, 0]))]
    if last - first < LEAST_BINS or last - first > counts.size - 2 * LEAST_BINS:
        return None
    start, end = (int(time[0] + width * own) for own in (first, last))
    inside = (time >= start) & (time < end)
    if _to_and_fro(values[inside]) < TO_AND_FRO or _to_and_fro(values[time < start]) > AWAY:
        return None
    return int(start - width), int(end + width)


def _to_and_fro(values: np.ndarray) -> float:
    """The median step to the next value over that to the one after it."""
    if values.size < 3:
        return 0.0
    two = float(np.median(np.abs(values[2:] - values[:-2])))
    one = float(np.median(np.abs(np.diff(values))))
    return one / two if two > 0.0 else (np.inf if one > 0.0 else 0.0)
