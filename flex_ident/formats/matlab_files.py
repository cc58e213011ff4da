"""MATLAB files up to version 7.2 (`save -v7`), by scipy: variables and fields of structures, not objects."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from flex_ident.errors import SignalError
from flex_ident.formats.arrays import matrix_columns
from flex_ident.formats.tables import MOST_NUMBERS
from flex_ident.parameters.documents import opened_file
from flex_ident.recording import Floats
from flex_ident.recording.names import harmless, path_text

MAGIC = b"MATLAB 5.0 MAT-file"
HEADER_BYTES = 128
COMPRESSED = 15
"""The type of an element that zlib has packed."""
DEEPEST = 16
PIECE = 1 << 20


class MatlabFile:
    """A MATLAB file of version 5: its numeric variables as columns, a matrix as `NAME.NUMBER`. Raises SignalError."""

    scales: Mapping[str, float] = {}

    def __init__(self, path: Path) -> None:
        self.source = path_text(path)
        try:
            _refuse_large(path, self.source)
            content: dict[str, Any] = scipy.io.loadmat(path, simplify_cells=True)
        except OSError as error:
            raise SignalError(f"{self.source}: cannot be read ({error.strerror or error}).") from error
        except SignalError:
            raise
        except Exception as error:
            raise SignalError(
                f"{self.source}: is damaged ({type(error).__name__} where MATLAB's data should be)."
            ) from error
        arrays: dict[str, Any] = {}
        _collect(arrays, {k: v for k, v in content.items() if not k.startswith("__")}, "", DEEPEST)
        self._columns = matrix_columns(arrays)
        if not self._columns:
            raise SignalError(
                f"{self.source}: holds no numeric arrays: save timetables and other objects as plain variables."
            )

    @property
    def columns(self) -> Collection[str]:
        """Names of the columns."""
        return self._columns

    def read(self, names: Collection[str]) -> dict[str, Floats]:
        """The columns (n,) of these names."""
        return {name: np.array(self._columns[name], np.float64) for name in names}


def _collect(arrays: dict[str, Any], value: Any, path: str, levels: int) -> None:
    """Numeric arrays in structures within structures, by dotted path."""
    if isinstance(value, dict) and levels:
        for key, inner in value.items():
            _collect(arrays, inner, f"{path}.{harmless(key)}" if path else harmless(key), levels - 1)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "bifu" and value.size > 1 and value.ndim <= 3:
        arrays[path] = np.squeeze(value)


def _refuse_large(path: Path, source: str) -> None:
    """Raise SignalError when what is packed in the file is larger than memory should be given for."""
    most, total = 8 * MOST_NUMBERS, 0
    with opened_file(path) as file:
        head = file.read(HEADER_BYTES)
        order = ">" if head[126:128] == b"MI" else "<"
        while len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            if kind != COMPRESSED:
                total += size
                file.seek(size, 1)
            else:
                unpacker, left = zlib.decompressobj(), size
                while left > 0 and total <= most and (piece := file.read(min(PIECE, left))):
                    left -= len(piece)
                    while piece and total <= most:
                        total += len(unpacker.decompress(piece, PIECE))
                        piece = unpacker.unconsumed_tail
            if total > most:
                raise SignalError(f"{source}: unpacks to over {most:.3g} bytes: save fewer variables.")
