"""From stamps and values as they lie in a bag to a `Signal`: finite, each once, in increasing time."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from flex_ident.errors import SignalError
from flex_ident.notices import Code, Notice
from flex_ident.recording.recording import Floats, Role, Signal

JUMP_PERIODS = 20.0
"""Periods from which time that goes back is a clock that was set, and not a sample out of order."""
NEIGHBOURS = 5
FEW_DUPLICATES = 0.01
"""Share of messages that may repeat a stamp, as when a publisher sends one again, without a word."""
LARGEST = 1e12
"""Magnitude of a value or time, SI, from which it is damage and no measurement."""


def measurable(values: Floats) -> NDArray[np.bool_]:
    """Which of the values are numbers that may have been measured: finite, and of a magnitude that is no damage."""
    with np.errstate(invalid="ignore"):
        found: NDArray[np.bool_] = np.abs(values) < LARGEST
    return found


def cleaned_signal(
    role: Role, source: str, clock: Literal["header", "receive"], time: Floats, values: Floats
) -> tuple[Signal, list[Notice]]:
    """The signal without what is not a number, duplicate or out of time. Raises SignalError when nothing is left.

    A single stamp far from its neighbours is dropped. Where time jumps back by many periods (a clock was set) the
    longest stretch is kept; single samples out of order are dropped.
    """
    notices: list[Notice] = []
    total = values.size
    finite = measurable(values) & measurable(time)
    nonfinite = int(total - finite.sum())
    if total == 0 or not finite.any():
        what = "no messages" if total == 0 else f"none of {total} values that is a finite number"
        raise SignalError(f"{source} holds {what}: name another signal.")
    if nonfinite:
        time, values = time[finite], values[finite]
        notices.append(Notice(Code.NONFINITE_VALUES, source, {"count": nonfinite, "total": total}))
    steps = np.diff(time)
    forward = steps[steps > 0]
    period = float(np.median(forward)) if forward.size else 0.0
    backwards = single = 0
    if forward.size < steps.size:
        lone = _lone_stamps(time, JUMP_PERIODS * period)
        time, values = time[~lone], values[~lone]
        single = int(np.count_nonzero(lone))
        backwards += single
        stretch, jumps = _longest_stretch(time, JUMP_PERIODS * period)
        if jumps.size:
            kept = stretch.stop - stretch.start
            backwards += time.size - kept
            place = np.flatnonzero(np.diff(time) < -JUMP_PERIODS * period)[int(np.argmax(jumps))]
            sizes = {
                "jumps": jumps.size, "largest_s": jumps.max(), "at_s": time[place] - time[0], "kept": kept,
                "dropped": time.size - kept,
            }  # fmt: skip
            notices.append(Notice(Code.TIME_JUMPED_BACK, source.partition(":")[0], sizes))
            time, values = time[stretch], values[stretch]
    keep = np.ones(time.size, bool)
    keep[1:] = time[1:] > np.maximum.accumulate(time)[:-1]
    duplicates = int(np.count_nonzero(np.diff(time) == 0))
    disordered = max(0, int(np.count_nonzero(~keep)) - duplicates)
    backwards += disordered
    if single + disordered:
        sizes = {"count": single + disordered, "total": total}
        notices.append(Notice(Code.STAMPS_OUT_OF_ORDER, source.partition(":")[0], sizes))
    if time.size > 1 and duplicates > FEW_DUPLICATES * total and keep.sum() > 1:
        sizes = {"count": duplicates, "total": total}
        notices.append(Notice(Code.DUPLICATE_STAMPS, source.partition(":")[0], sizes))
    if not keep.all():
        time, values = time[keep], values[keep]
    if total == 1:
        raise SignalError(f"{source} holds one message: record at least ten seconds of motion.")
    if time.size < 2:
        raise SignalError(f"time of {source} does not advance over {total} messages: is its clock set?")
    return Signal(role, source, clock, time, values, nonfinite, duplicates, backwards), notices


def _lone_stamps(time: Floats, tolerance: float) -> NDArray[np.bool_]:
    """Which (n,) stamps lie off the median of their neighbours by more than `tolerance`, s: damaged ones.

    A gap or a clock that was set leaves none: time that increases on both sides is its own running median.
    """
    if time.size <= NEIGHBOURS:
        return np.zeros(time.size, bool)
    lone: NDArray[np.bool_] = np.abs(time - ndimage.median_filter(time, NEIGHBOURS, mode="nearest")) > tolerance
    return lone


def _longest_stretch(time: Floats, tolerance: float) -> tuple[slice, Floats]:
    """The longest stretch in which time does not go back by more than `tolerance`, and by how much it goes back, s."""
    steps = np.diff(time)
    jumps = np.flatnonzero(steps < -tolerance)
    edges = np.concatenate(([0], jumps + 1, [time.size]))
    longest = int(np.argmax(np.diff(edges)))
    return slice(int(edges[longest]), int(edges[longest + 1])), -steps[jumps]
