"""From stamps and values as they lie in a bag to a `Signal`: finite, each once, in increasing time."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import SignalError
from flex_ident.recording.recording import Floats, Notice, Role, Signal

JUMP_PERIODS = 20.0


def usable_stamps(stamps: NDArray[np.int64]) -> bool:
    """Whether header stamps (k,), ns, can serve as the clock: set, and mostly increasing."""
    if stamps.size < 2 or np.count_nonzero(stamps) < stamps.size:
        return False
    return float(np.mean(np.diff(stamps) > 0)) > 0.5


def cleaned_signal(
    role: Role, source: str, clock: Literal["header", "receive"], time: Floats, values: Floats
) -> tuple[Signal, list[Notice]]:
    """The signal without what is not a number, duplicate or out of time. Raises SignalError when nothing is left.

    Where time jumps back by many periods (a clock was set) the longest stretch is kept; single samples out of order
    are dropped.
    """
    notices: list[Notice] = []
    total = values.size
    finite = np.isfinite(values) & np.isfinite(time)
    nonfinite = int(total - finite.sum())
    if total == 0 or not finite.any():
        what = "no messages" if total == 0 else f"none of {total} values that is a finite number"
        raise SignalError(f"{source} holds {what}: name another signal.")
    time, values = time[finite], values[finite]
    steps = np.diff(time)
    forward = steps[steps > 0]
    period = float(np.median(forward)) if forward.size else 0.0
    backwards = 0
    jumps = np.flatnonzero(steps < -JUMP_PERIODS * period)
    if jumps.size:
        edges = [0, *(jumps + 1).tolist(), time.size]
        longest = max(range(len(edges) - 1), key=lambda i: edges[i + 1] - edges[i])
        start, stop = edges[longest], edges[longest + 1]
        backwards += time.size - (stop - start)
        notices.append(
            Notice(
                "time_jumped_back",
                f"time of {source} jumps back {jumps.size} times, by {-float(steps[jumps].min()):.3g} s at most: the "
                f"longest stretch of {stop - start} samples was kept, {time.size - (stop - start)} were dropped.",
            )
        )
        time, values = time[start:stop], values[start:stop]
    ahead = np.maximum.accumulate(time)
    keep = np.ones(time.size, bool)
    keep[1:] = time[1:] > ahead[:-1]
    duplicates = int(np.count_nonzero(np.diff(time) == 0))
    backwards += max(0, int(np.count_nonzero(~keep)) - duplicates)
    time, values = time[keep], values[keep]
    if time.size < 2:
        raise SignalError(f"time of {source} does not advance over {total} messages: is its clock set?")
    if nonfinite:
        text = f"{nonfinite} of {total} values of {source} are not finite numbers and were dropped."
        notices.append(Notice("nonfinite_values", text))
    signal = Signal(role, source, clock, time, values, nonfinite, duplicates, backwards)
    return signal, notices
