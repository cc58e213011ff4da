"""MATLAB files up to version 7.2 (`save -v7`), by scipy: variables and fields of structures, not objects."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np

from flex_ident.errors import SignalError
from flex_ident.formats.arrays import matrix_columns
from flex_ident.formats.matlab_content import MatlabContentError, matlab_arrays
from flex_ident.formats.tables import MOST_NUMBERS
from flex_ident.parameters.documents import opened_file
from flex_ident.recording import Floats
from flex_ident.recording.names import path_text

MAGIC = b"MATLAB 5.0 MAT-file"
HEADER_BYTES = 128
COMPRESSED = 15
"""The type of an element that zlib has packed."""
PIECE = 1 << 20


class MatlabFile:
    """A MATLAB file of version 5: its numeric variables as columns, a matrix as `NAME.NUMBER`. Raises SignalError."""

    scales: Mapping[str, float] = {}

    def __init__(self, path: Path) -> None:
        self.source = path_text(path)
        try:
            _refuse_large(path, self.source)
            arrays = matlab_arrays(path)
        except OSError as error:
            raise SignalError(f"{self.source}: cannot be read ({error.strerror or error}).") from error
        except (MatlabContentError, zlib.error) as error:
            raise SignalError(f"{self.source}: is damaged ({error}).") from error
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
