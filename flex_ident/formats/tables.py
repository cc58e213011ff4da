"""What every kind of table looks like from outside: columns of numbers by name, read when they are asked for."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Protocol

from flex_ident.errors import SignalError
from flex_ident.recording import Floats
from flex_ident.recording.names import first_of

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
    return first_of(columns, MOST_LISTED)


def refuse_large(source: str, rows: int, columns: int) -> None:
    """Raise SignalError when the numbers would not fit into memory."""
    if rows * columns > MOST_NUMBERS:
        raise SignalError(
            f"{source}: {columns} columns of {rows} rows are {rows * columns:.3g} numbers: {MOST_NUMBERS:.3g} are read "
            "at most: cut the file, or name fewer joints."
        )


class SideBySide:
    """Several tables as one: a column `NAME` of `FILE.csv` is called `FILE.NAME`, and `FILE` where it is the only one.

    Raises SignalError where two of the `files` are called alike.
    """

    def __init__(self, tables: Mapping[str, Table], files: int) -> None:
        if len(tables) < files:
            raise SignalError(f"two of the files are called alike: {', '.join(tables)}: rename one.")
        self.source = ", ".join(table.source for table in tables.values())
        self._at: dict[str, tuple[Table, str]] = {}
        for stem, table in tables.items():
            own = list(table.columns)
            self._at.update({stem if len(own) == 1 else f"{stem}.{name}": (table, name) for name in own})
        self.scales = {name: table.scales[own] for name, (table, own) in self._at.items() if own in table.scales}

    @property
    def columns(self) -> Collection[str]:
        """Names of all columns, file after file."""
        return self._at

    def read(self, names: Collection[str]) -> dict[str, Floats]:
        """The columns (n,) of these names."""
        found: dict[str, Floats] = {}
        for table in dict.fromkeys(self._at[name][0] for name in names):
            own = {name: self._at[name][1] for name in names if self._at[name][0] is table}
            content = table.read(list(dict.fromkeys(own.values())))
            found.update({name: content[inner] for name, inner in own.items()})
        return {name: found[name] for name in names}
