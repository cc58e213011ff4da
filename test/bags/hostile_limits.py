"""In how much memory what was made to hurt may be looked at."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager


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
