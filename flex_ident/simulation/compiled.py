"""numba where it is installed, plain Python (a hundred times slower, the same numbers) where it is not."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

try:
    from numba import njit as _njit

    COMPILED = True
except ImportError:  # numba is optional: python3-numba
    COMPILED = False


def sources() -> str:
    """A hash of all that compiled functions are made of: numba looks at each function's own file only, and would go on
    with a cached one whose callees, or whose indices of the terms, have changed since."""
    package = Path(__file__).resolve().parents[1]
    files = sorted(p for folder in ("simulation", "virtual_joint") for p in (package / folder).glob("*.py"))
    return hashlib.sha256(b"".join(p.read_bytes() for p in files)).hexdigest()


STAMP = sources() if COMPILED else ""


def compiled(function: F) -> F:
    """`function` compiled on its first call and cached on disk, or unchanged without numba."""
    if not COMPILED:
        return function
    try:
        jitted: F = _njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # no folder to cache in: a read-only installation without a home
        jitted = _njit(nogil=True, error_model="numpy")(function)
    index = getattr(getattr(jitted, "_cache", None), "_cache_file", None)
    if index is not None and hasattr(index, "_source_stamp"):
        index._source_stamp = (index._source_stamp, STAMP)
    return jitted
