"""numba where it is installed, plain Python (a hundred times slower, the same numbers) where it is not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

try:
    from numba import njit as _njit

    COMPILED = True
except ImportError:  # numba is optional: python3-numba
    COMPILED = False


def compiled(function: F) -> F:
    """`function` compiled on its first call and cached on disk, or unchanged without numba."""
    if not COMPILED:
        return function
    try:
        jitted: F = _njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # no folder to cache in: a read-only installation without a home
        jitted = _njit(nogil=True, error_model="numpy")(function)
    return jitted
