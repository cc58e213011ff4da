"""How work comes to an end by signal: by an exception that cleans up, and never in the middle of `unbroken` work."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
AGAIN_S = 2.0
"""Time, s, in which further signals are passed over: a closing terminal sends several, and cleaning up takes time."""
NEVER = float("-inf")


class Stopped(KeyboardInterrupt):
    """A signal asks to end. `exit_status` is the one that a shell gives to what the signal ends."""

    def __init__(self, number: int) -> None:
        super().__init__(f"stopped by {signal.Signals(number).name}")
        self.exit_status = 128 + number


class _State:
    """What came while work must not be broken, how deep within such work we are, and when a signal was last heeded."""

    pending = 0
    depth = 0
    heeded = NEVER


_state = _State()


@contextmanager
def stoppable() -> Iterator[None]:
    """Signals raise Stopped in the block, in the main thread. What is ignored, as SIGHUP by nohup, stays so.

    Once one has, they still do after the block: the process is about to end, and shall do so with its own status.
    """
    before = {}
    if threading.current_thread() is threading.main_thread():
        _state.pending, _state.heeded = 0, NEVER
        defaults = (signal.SIG_DFL, signal.default_int_handler)
        before = {n: signal.signal(n, _heed) for n in SIGNALS if signal.getsignal(n) in defaults}
    try:
        yield
    finally:
        for number, handler in before.items() if not stopped() else ():
            signal.signal(number, handler)


def stopped() -> bool:
    """Whether a signal has raised Stopped in the block of `stoppable`."""
    return _state.heeded != NEVER


@contextmanager
def unbroken() -> Iterator[None]:
    """Signals that come in the block raise Stopped at its end."""
    if threading.current_thread() is not threading.main_thread():  # signals are never heeded there
        yield
        return
    _state.depth += 1
    try:
        yield
    finally:
        _state.depth -= 1
        if _state.pending and not _state.depth:
            number, _state.pending = _state.pending, 0
            _state.heeded = time.monotonic()
            raise Stopped(number)


def _heed(number: int, _frame: FrameType | None) -> None:
    if time.monotonic() - _state.heeded < AGAIN_S:
        return
    if _state.depth:
        _state.pending = number
        return
    _state.heeded = time.monotonic()
    raise Stopped(number)
