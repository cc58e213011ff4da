"""The same work on many sets of values, on all cores where that is quicker."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

Result = TypeVar("Result")
WORTH_THREADS = 20_000
"""Samples of a recording from which threads are quicker on two cores: below, waiting for the interpreter costs more
than they save (recordings 3, 5, 7, 9 and 13 of seed 7001 of `bench/coverage.py`: 5 to 10 % of an identification)."""


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def mapped(function: Callable[..., Result], *items: Iterable[Any], samples: int) -> list[Result]:
    """`map` as a list, in the same order; in threads if a recording of so many samples is worth it."""
    cores = usable_cores()
    if cores == 1 or samples < WORTH_THREADS:
        return list(map(function, *items))
    with ThreadPoolExecutor(cores) as pool:
        return list(pool.map(function, *items))
