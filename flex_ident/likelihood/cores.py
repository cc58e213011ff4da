"""The same work on many sets of values, on all cores where that is quicker; and where work that takes long may stop."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar

Result = TypeVar("Result")
WORTH_THREADS = 20_000
"""Samples of a recording from which threads are quicker on two cores: below, waiting for the interpreter costs more
than they save (recordings 3, 5, 7, 9 and 13 of seed 7001 of `bench/coverage.py`: 5 to 10 % of an identification)."""
_ASKED: ContextVar[Callable[[], bool]] = ContextVar("asked", default=lambda: False)


class WorkStoppedError(BaseException):
    """Work was asked to stop. Not an Exception: nothing that fails on the way and is tried otherwise may catch it."""


@contextmanager
def stopped_when(asked: Callable[[], bool]) -> Iterator[None]:
    """Work inside, in this thread, raises WorkStoppedError soon after `asked` has become true."""
    token = _ASKED.set(asked)
    try:
        yield
    finally:
        _ASKED.reset(token)


def stop_if_asked() -> None:
    """Raise WorkStoppedError where the work around was asked to stop."""
    if _ASKED.get()():
        raise WorkStoppedError


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def mapped(function: Callable[..., Result], *items: Iterable[Any], samples: int) -> list[Result]:
    """`map` as a list, in the same order; in threads if a recording of so many samples is worth it.

    Raises WorkStoppedError when the work around was asked to stop.
    """
    stop_if_asked()
    cores = usable_cores()
    if cores == 1 or samples < WORTH_THREADS:
        return list(map(function, *items))
    with ThreadPoolExecutor(cores) as pool:
        return list(pool.map(function, *items))
