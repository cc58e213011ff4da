"""How long, and in how much memory, what was made to hurt may be looked at."""

from __future__ import annotations

import signal
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def in_seconds(seconds: float) -> Iterator[None]:
    """Raise AssertionError when this process works for longer within: it may be without end."""

    def ended(_number: int, _frame: FrameType | None) -> None:
        raise AssertionError(f"took over {seconds} s of processor time")

    before = signal.signal(signal.SIGPROF, ended)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@contextmanager
def in_mebibytes(most: float) -> Iterator[None]:
    """Raise AssertionError when more memory than that is taken within, as far as Python and numpy count it."""
    tracemalloc.start()
    try:
        yield
        peak = tracemalloc.get_traced_memory()[1] / 2**20
    finally:
        tracemalloc.stop()
    assert peak < most, f"took {peak:.0f} MiB"
