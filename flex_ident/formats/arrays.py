"""Arrays of one or two dimensions as columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from flex_ident.formats.tables import MOST_COLUMNS

WIDEST = 256
"""Columns of a matrix, at most: more are no joints."""


def samples_axis(shape: tuple[int, ...], lengths: Counter[int]) -> int:
    """The axis of a matrix along which samples run: that as long as the most vectors are, else the longer one."""
    if len(shape) < 2:
        return 0
    if (shape[0] in lengths) != (shape[1] in lengths):
        return 0 if shape[0] in lengths else 1
    return 0 if shape[0] >= shape[1] else 1


def matrix_columns(arrays: Mapping[str, Any]) -> dict[str, Any]:
    """Columns by name, of vectors (n,) and matrices (n, k) or (k, n): `NAME`, or `NAME.0` to `NAME.k-1`."""
    lengths = Counter(array.shape[0] for array in arrays.values() if array.ndim == 1)
    found: dict[str, Any] = {}
    for name, array in arrays.items():
        if array.ndim == 1:
            found[name] = array
        elif array.ndim == 2 and min(array.shape) <= WIDEST:
            rows = array if samples_axis(array.shape, lengths) == 0 else array.T
            found.update((f"{name}.{i}", rows[:, i]) for i in range(rows.shape[1]))
        if len(found) >= MOST_COLUMNS:
            break
    return found
