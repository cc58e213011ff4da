"""numba where it is installed, plain Python where it is not; kept apart from the estimator's own on purpose."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

try:
    from numba import njit as _njit
except ImportError:  # numba is optional: python3-numba
    _njit = None


def compiled(function: F) -> F:
    """`function` compiled on its first call and cached on disk, or unchanged without numba."""
    if _njit is None:
        return function
    try:
        jitted: F = _njit(cache=True, nogil=True)(function)
    except RuntimeError:  # no folder to cache in: a read-only installation without a home
        jitted = _njit(nogil=True)(function)
    return jitted
