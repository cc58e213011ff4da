"""NumPy files: an archive of arrays (`.npz`), or one array (`.npy`); no objects."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flex_ident.errors import SignalError
from flex_ident.formats.arrays import matrix_columns
from flex_ident.formats.tables import MOST_NUMBERS
from flex_ident.parameters.documents import opened_file
from flex_ident.recording import Floats
from flex_ident.recording.names import harmless, path_text

ARRAY = b"\x93NUMPY"
MAGICS = (ARRAY, b"PK\x03\x04")
FREE, RATIO = 32 << 20, 200
"""Bytes that an archive unpacks to, at most: so many, and so many for each packed one."""
HEADERS: dict[tuple[int, int], Callable[[Any], Any]] = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
"""What reads shape, order and type of an array, by the version of its file."""
ALONE = "column"
"""What the one array of a `.npy` is called: its columns are `column.0`, `column.1`, ..."""


class NumpyFile:
    """The numeric arrays of a NumPy file as columns, a matrix as `NAME.NUMBER`. Raises SignalError."""

    scales: Mapping[str, float] = {}

    def __init__(self, path: Path) -> None:
        self.source = path_text(path)
        try:
            with opened_file(path) as file:
                arrays = _archive(file, self.source) if file.peek(4)[:2] == b"PK" else _alone(file, self.source)
        except OSError as error:
            raise SignalError(f"{self.source}: cannot be read ({error.strerror or error}).") from error
        except SignalError:
            raise
        except Exception as error:
            raise SignalError(
                f"{self.source}: is damaged, or no NumPy file ({type(error).__name__} where its arrays should be)."
            ) from error
        self._columns = matrix_columns(arrays)
        if not self._columns:
            raise SignalError(f"{self.source}: holds no numeric arrays: objects are not read.")

    @property
    def columns(self) -> Collection[str]:
        """Names of the columns."""
        return self._columns

    def read(self, names: Collection[str]) -> dict[str, Floats]:
        """The columns (n,) of these names."""
        return {name: np.array(self._columns[name], np.float64) for name in names}


def _archive(file: Any, source: str) -> dict[str, Any]:
    with zipfile.ZipFile(file) as archive:
        members = [m for m in archive.infolist() if m.filename.endswith(".npy")]
        total = sum(m.file_size for m in members)
        _refuse_large(total, source)
        _refuse_unpacking(total, sum(m.compress_size for m in members), source)
        found = {}
        for member in members:
            name = harmless(member.filename.removesuffix(".npy"))
            with archive.open(member) as inner:
                found[name] = _numbers(inner, member.file_size, f"{source}: {name}")
    return {name: array for name, array in found.items() if array is not None}


def _alone(file: Any, source: str) -> dict[str, Any]:
    size = file.seek(0, 2)
    file.seek(0)
    _refuse_large(size, source)
    array = _numbers(file, size, source)
    if array is None:
        return {}
    return {ALONE: array}


def _numbers(file: Any, size: int, source: str) -> Any | None:
    """The array in a file of `size` bytes, squeezed; None where it holds no numbers or is no table.

    Raises SignalError where its header announces more than the file holds.
    """
    reader = HEADERS.get(np.lib.format.read_magic(file))
    if reader is not None:
        shape, _, kind = reader(file)
        if kind.hasobject:
            return None
        announced, left = math.prod(shape) * kind.itemsize, size - file.tell()
        if announced > left:
            raise SignalError(
                f"{source}: announces {announced:.3g} bytes of numbers and holds {left}: it is cut, or damaged."
            )
    file.seek(0)
    try:
        array = np.lib.format.read_array(file, allow_pickle=False)
    except ValueError as error:
        if "Object arrays" in str(error):
            return None
        raise
    array = np.squeeze(array)
    return array if array.dtype.kind in "bifu" and array.size > 1 and array.ndim <= 2 else None


def _refuse_unpacking(size: int, packed: int, source: str) -> None:
    """Raise SignalError when so few bytes unpack to more than any measurement does."""
    if size > FREE + RATIO * packed:
        raise SignalError(
            f"{source}: {packed} bytes unpack to {size:.3g}, over {RATIO} times as many: this is no measurement."
        )


def _refuse_large(size: int, source: str) -> None:
    """Raise SignalError when the numbers would not fit into memory."""
    if size > 8 * MOST_NUMBERS:
        raise SignalError(f"{source}: holds {size:.3g} bytes: {8 * MOST_NUMBERS:.3g} are read at most: save less.")
