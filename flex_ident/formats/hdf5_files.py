"""HDF5 files, MATLAB's of version 7.3 (`save -v7.3`) among them, by h5py."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flex_ident.bags.extras import extra_module
from flex_ident.errors import SignalError
from flex_ident.formats.arrays import WIDEST, samples_axis
from flex_ident.formats.tables import MOST_COLUMNS, refuse_large
from flex_ident.recording import Floats
from flex_ident.recording.names import harmless, path_text

MAGIC = b"\x89HDF\r\n\x1a\n"
USER_BLOCK = 512
"""Where the file begins behind what MATLAB writes in front of it."""
MOST_OBJECTS = 1 << 16


class Hdf5File:
    """An HDF5 file: its numeric datasets as columns, `GROUP.NAME`, a matrix as `GROUP.NAME.NUMBER`.

    Raises MissingExtraError without h5py, and SignalError.
    """

    scales: Mapping[str, float] = {}

    def __init__(self, path: Path) -> None:
        self._path, self.source = path, path_text(path)
        self._h5py = extra_module("h5py", "hdf5", f"HDF5 files such as {self.source}")
        shapes = self._guarded(self._shapes)
        lengths = Counter(shape[0] for shape, _ in shapes.values() if len(shape) == 1)
        self._places: dict[str, tuple[str, int, int]] = {}
        """Dataset, axis of the samples and number along the other one, of each column."""
        for name, (shape, place) in shapes.items():
            axis = samples_axis(shape, lengths)
            wide = shape[1 - axis] if len(shape) == 2 else 1
            for i in range(wide):
                self._places[f"{name}.{i}" if len(shape) == 2 and wide > 1 else name] = (place, axis, i)
            if len(self._places) >= MOST_COLUMNS:
                break
        if not self._places:
            raise SignalError(f"{self.source}: holds no numeric arrays: save objects as plain variables.")

    @property
    def columns(self) -> Collection[str]:
        """Names of the columns."""
        return self._places

    def read(self, names: Collection[str]) -> dict[str, Floats]:
        """The columns (n,) of these names."""
        columns: dict[str, Floats] = self._guarded(lambda file: self._read(file, names))
        return columns

    def _read(self, file: Any, names: Collection[str]) -> dict[str, Floats]:
        found: dict[str, Floats] = {}
        for name in names:
            place, axis, i = self._places[name]
            dataset = file[place]
            refuse_large(self.source, dataset.shape[axis], len(names))
            if len(dataset.shape) == 1:
                found[name] = np.asarray(dataset[:], np.float64)
            else:
                found[name] = np.asarray(dataset[:, i] if axis == 0 else dataset[i, :], np.float64)
        return found

    def _shapes(self, file: Any) -> dict[str, tuple[tuple[int, ...], str]]:
        """Shape and place of each numeric dataset, by dotted name."""
        found: dict[str, tuple[tuple[int, ...], str]] = {}
        met = 0

        def visit(place: str, item: Any) -> bool | None:
            nonlocal met
            met += 1
            numeric = isinstance(item, self._h5py.Dataset) and item.dtype.kind in "bifu" and item.external is None
            if numeric and 1 <= len(item.shape) <= 2 and not item.is_virtual and not place.startswith("#"):
                shape = tuple(int(n) for n in item.shape)
                if max(shape) > 1 and min(shape) >= 1 and (len(shape) == 1 or min(shape) <= WIDEST):
                    found[harmless(place).replace("/", ".")] = (shape, place)
            return True if met >= MOST_OBJECTS else None

        file.visititems(visit)
        return found

    def _guarded(self, action: Any) -> Any:
        """What `action` makes of the open file. Raises SignalError."""
        try:
            with self._h5py.File(self._path, "r") as file:
                return action(file)
        except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
            why = getattr(error, "strerror", None) or "damaged, or not HDF5"
            raise SignalError(f"{self.source}: cannot be read ({why}).") from error
