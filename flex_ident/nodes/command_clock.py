"""Ticks of a steady clock in a thread of their own; a late tick skips, and how late they were is counted."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

import numpy as np

PRIORITY, AROUND = 20, 10
"""Real-time priority of the thread, where the system allows one, and of those beside it: what holds Python's lock and
has to wait for the processor keeps the commands waiting with it."""


@dataclass
class Punctuality:
    """How late ticks came, s; each beside the one that was due when it came."""

    rate_hz: float
    late: list[float] = field(default_factory=list)
    began: float = 0.0
    ended: float = 0.0
    skipped: int = 0

    def add(self, now: float, late: float, skipped: int) -> None:
        """Count a tick, and those that it came too late for."""
        if not self.late:
            self.began = now
        self.ended = now
        self.late.append(late)
        self.skipped += skipped

    @property
    def known(self) -> bool:
        """Whether there were ticks enough to tell."""
        return len(self.late) >= 2

    @property
    def achieved_hz(self) -> float:
        """Ticks a second."""
        span = self.ended - self.began
        return (len(self.late) - 1) / span if span > 0.0 else 0.0

    def __str__(self) -> str:
        if not self.known:
            return "no commands of the chirp were sent: no jitter to tell"
        p50, p99, most = 1e6 * np.percentile(self.late, (50, 99, 100))
        return (
            f"{len(self.late)} commands at {self.achieved_hz:.1f} of {self.rate_hz:g} Hz, {self.skipped} skipped; "
            f"jitter {p50:.0f} us (50 %), {p99:.0f} us (99 %), {most:.0f} us (most)"
        )


class CommandClock:
    """Calls `tick(now, late, skipped)` at a rate until it returns False or the clock is stopped; times in s."""

    def __init__(self, rate_hz: float, tick: Callable[[float, float, int], bool]) -> None:
        self._period = 1.0 / rate_hz
        self._tick = tick
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="commands", daemon=True)
        self.error: Exception | None = None
        self.real_time = False

    def start(self) -> None:
        """Begin to tick."""
        self._thread.start()

    @property
    def ticking(self) -> bool:
        """Whether the thread runs."""
        return self._thread.is_alive()

    def join(self, timeout_s: float) -> None:
        """Wait until the last tick."""
        if self._thread.is_alive():
            self._thread.join(timeout_s)

    def stop(self, timeout_s: float = 1.0) -> None:
        """End at the next tick."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(timeout_s)

    def _run(self) -> None:
        self.real_time = real_time()
        try:
            self._tick_on()
        except Exception as error:
            self.error = error

    def _tick_on(self) -> None:
        begin, k = time.monotonic(), 0
        while not self._stopping.is_set():
            due = begin + k * self._period
            wait = due - time.monotonic()
            if wait > 0.0:
                time.sleep(wait)
            now = time.monotonic()
            skipped = int((now - due) / self._period)
            k += 1 + skipped
            if not self._tick(now, now - due, skipped):
                return


def real_time(priority: int = PRIORITY) -> bool:
    """Give this thread, and those that it starts, real-time priority where the system allows it; whether it did.

    An ordinary user may not: jitter is measured and reported either way.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError):
        return False
    return True


@contextmanager
def threads_in_real_time(priority: int) -> Iterator[None]:
    """Threads that are started inside have real-time priority where the system allows it; this one only meanwhile.

    What takes long, and no robot waits for, must not keep a processor from others: a node's start takes a quarter of a
    second, and a process that is started inherits the priority for all of its imports.
    """
    if not hasattr(os, "sched_getscheduler"):
        yield
        return
    policy, before = os.sched_getscheduler(0), os.sched_getparam(0)
    real_time(priority)
    try:
        yield
    finally:
        with suppress(OSError):
            os.sched_setscheduler(0, policy, before)


class RosTime:
    """Instants of the steady clock, s, in ROS time, ns.

    The offset between the two lies between what a reading of ROS time gives with the steady clock just before it and
    just after it. It is kept as long as readings allow it, so that stamps are as even as the steady clock even where
    the thread is interrupted between two readings, and follows ROS time where that is corrected or simulated.
    """

    def __init__(self, ros_now_ns: Callable[[], int], steady_now_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self._ros_now_ns = ros_now_ns
        self._steady_now_ns = steady_now_ns
        self._offset_ns: int | None = None

    def at(self, instant: float) -> int:
        """That instant of the steady clock."""
        before = self._steady_now_ns()
        ros = self._ros_now_ns()
        after = self._steady_now_ns()
        if self._offset_ns is None:
            self._offset_ns = ros - (before + after) // 2
        self._offset_ns = min(max(self._offset_ns, ros - after), ros - before)
        return round(1e9 * instant) + self._offset_ns
