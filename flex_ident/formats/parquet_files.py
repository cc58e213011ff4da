"""Parquet files, by pyarrow: columns of numbers and of lists of numbers."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flex_ident.bags.extras import extra_module
from flex_ident.errors import SignalError
from flex_ident.formats.arrays import WIDEST
from flex_ident.formats.tables import refuse_large
from flex_ident.recording import Floats
from flex_ident.recording.names import harmless, path_text

MAGIC = b"PAR1"
ROWS = 1 << 15
"""Rows that are read together."""
NANOSECONDS = 1e-9


class ParquetFiles:
    """One or more Parquet files of the same columns, one after the other; a list's numbers are `NAME.NUMBER`.

    `labels` are names of a list's numbers, by column: `NAME.LABEL` then. `only` are the rows to take: those where a
    column has a value. Raises MissingExtraError without pyarrow, and SignalError.
    """

    def __init__(
        self, files: Sequence[Path], source: str, *, labels: Mapping[str, Sequence[str]] | None = None,
        only: tuple[str, int] | None = None,
    ) -> None:  # fmt: skip
        self._files, self.source, self._only = files, source, only
        self._arrow = extra_module("pyarrow", "parquet", f"Parquet files such as {self.source}")
        self._parquet = extra_module("pyarrow.parquet", "parquet", f"Parquet files such as {self.source}")
        self._compute = extra_module("pyarrow.compute", "parquet", f"Parquet files such as {self.source}")
        self.scales: dict[str, float] = {}
        self._places: dict[str, tuple[str, int]] = {}
        """Column of the file and number in its list, -1 where it is none, of each column."""
        with self._guard(files[0]):
            file = self._parquet.ParquetFile(files[0])
            schema = file.schema_arrow
            first = next(file.iter_batches(batch_size=1), None)
        for i, column in enumerate(schema):
            kind = column.type
            shown = harmless(column.name)
            if self._is_number(kind):
                self._places[shown] = (column.name, -1)
            elif self._arrow.types.is_timestamp(kind) or self._arrow.types.is_duration(kind):
                self._places[shown] = (column.name, -1)
                self.scales[shown] = NANOSECONDS
            elif self._is_list(kind) and first is not None and first.num_rows:
                size = len(first.column(i)[0].as_py() or [])
                names = list((labels or {}).get(column.name, ()))
                own = names if len(names) == size else [str(j) for j in range(min(size, WIDEST))]
                self._places.update((f"{shown}.{label}", (column.name, j)) for j, label in enumerate(own))

    @property
    def columns(self) -> Collection[str]:
        """Names of the columns."""
        return self._places

    def read(self, names: Collection[str]) -> dict[str, Floats]:
        """The columns (n,) of these names."""
        wanted = list(dict.fromkeys(self._places[name][0] for name in names))
        with_filter = [*wanted, *([self._only[0]] if self._only and self._only[0] not in wanted else [])]
        pieces: dict[str, list[Floats]] = {name: [] for name in names}
        rows = 0
        for batch in self._batches(with_filter):
            rows += batch.num_rows
            refuse_large(self.source, rows, len(names))
            keep = slice(None) if self._only is None else self._numbers(batch, self._only[0]) == self._only[1]
            for name in names:
                column, i = self._places[name]
                pieces[name].append((self._numbers(batch, column) if i < 0 else self._element(batch, column, i))[keep])
        return {name: np.concatenate(own) if own else np.zeros(0) for name, own in pieces.items()}

    def _batches(self, columns: Sequence[str]) -> Iterator[Any]:
        for path in self._files:
            with self._guard(path):
                yield from self._parquet.ParquetFile(path).iter_batches(batch_size=ROWS, columns=list(columns))

    def _numbers(self, batch: Any, name: str) -> Floats:
        column = batch.column(name)
        if harmless(name) in self.scales:
            unit = "timestamp" if self._arrow.types.is_timestamp(column.type) else "duration"
            column = column.cast(getattr(self._arrow, unit)("ns"), safe=False).cast("int64")
        return np.asarray(column.to_numpy(zero_copy_only=False), np.float64)

    def _element(self, batch: Any, name: str, index: int) -> Floats:
        """Number `index` of each row's list, NaN where the list is shorter."""
        column = batch.column(name)
        lengths = np.asarray(self._compute.list_value_length(column).to_numpy(zero_copy_only=False), np.float64)
        if lengths.size and (lengths == lengths[0]).all() and index < lengths[0]:
            whole = column.flatten().to_numpy(zero_copy_only=False)
            return np.asarray(whole.reshape(lengths.size, -1)[:, index], np.float64)
        rows = column.to_pylist()
        return np.array([row[index] if row is not None and len(row) > index else np.nan for row in rows], np.float64)

    def _is_number(self, kind: Any) -> bool:
        types = self._arrow.types
        return bool(
            types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind) or types.is_decimal(kind)
        )

    def _is_list(self, kind: Any) -> bool:
        types = self._arrow.types
        lists = types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind)
        return bool(lists and self._is_number(kind.value_type))

    def _guard(self, path: Path) -> _Guard:
        return _Guard(self._arrow, path_text(path))


class _Guard:
    """Turns what pyarrow complains of into a SignalError."""

    def __init__(self, arrow: Any, shown: str) -> None:
        self._arrow, self._shown = arrow, shown

    def __enter__(self) -> None: ...

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, SignalError):
            return
        if isinstance(error, (self._arrow.ArrowException, OSError, ValueError, KeyError)):
            why = getattr(error, "strerror", None) or "damaged, or not Parquet"
            raise SignalError(f"{self._shown}: cannot be read ({why}).") from error
