"""What must not wait, or work, for ever, in tests."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def no_longer_than(seconds: float, *, processor: bool = False) -> Iterator[None]:
    """Raises AssertionError in the block once it has taken so long; `processor`: so much of this process's own time."""
    number, timer = (signal.SIGPROF, signal.ITIMER_PROF) if processor else (signal.SIGALRM, signal.ITIMER_REAL)

    def late(_number: int, _frame: FrameType | None) -> None:
        raise AssertionError(f"took longer than {seconds:g} s{' of processor time' * processor}")

    before = signal.signal(number, late)
    signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        signal.setitimer(timer, 0.0)
        signal.signal(number, before)
