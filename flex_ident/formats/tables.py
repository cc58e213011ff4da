"""What every kind of table looks like from outside: columns of numbers by name, read when they are asked for."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Protocol

from flex_ident.errors import SignalError
from flex_ident.recording import Floats

MOST_COLUMNS = 4096
"""Columns of a table, at most."""
MOST_NUMBERS = 1 << 27
"""Numbers that are read of a table, at most: 1 GiB."""
MOST_LISTED = 24
"""Columns that a message lists."""


class Table(Protocol):
    """An opened table; `source` is its name as it can be shown."""

    source: str

    @property
    def columns(self) -> Collection[str]:
        """Names of the columns, in the file's order; that of a matrix is called `NAME.NUMBER`, counted from 0."""
        ...

    @property
    def scales(self) -> Mapping[str, float]:
        """What the file itself says a column is to be multiplied by, to be in SI units."""
        ...

    def read(self, names: Collection[str]) -> dict[str, Floats]:
        """The columns (n,) of these names; what is no number is NaN. Raises SignalError."""
        ...


def listed(columns: Collection[str]) -> str:
    """Columns, for a message."""
    names = list(columns)
    return ", ".join(names[:MOST_LISTED]) + (
        f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    )


def refuse_large(source: str, rows: int, columns: int) -> None:
    """Raise SignalError when the numbers would not fit into memory."""
    if rows * columns > MOST_NUMBERS:
        raise SignalError(
            f"{source}: {columns} columns of {rows} rows are {rows * columns:.3g} numbers: {MOST_NUMBERS:.3g} are read "
            "at most: cut the file, or name fewer joints."
        )
