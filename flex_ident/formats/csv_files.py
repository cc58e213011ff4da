"""CSV files: a line of names if there is one, then numbers, whatever separates them."""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime, time
from pathlib import Path

import numpy as np

from flex_ident.errors import SignalError
from flex_ident.formats.tables import MOST_COLUMNS, refuse_large
from flex_ident.parameters.documents import opened_file
from flex_ident.recording import Floats
from flex_ident.recording.names import decoded, path_text

LONGEST_LINE = 1 << 20
DELIMITERS = ",;"
"""Separators; a tab is read as a semicolon, and blanks separate where there is none of these."""
COMMENTS = ("#", "%")
"""What begins a line that is no row."""
ROWS = 1 << 14
"""Rows that are turned into numbers together."""


class CsvFile:
    """A CSV file, separated by comma, semicolon, tab or blanks.

    Its columns are named by its first line, comments before it left out, or by the last of these where numbers follow
    at once. One without names has `column_1`, `column_2`, ... Raises SignalError in one line. Lines shorter than the
    first are NaN where they lack a number.
    """

    scales: Mapping[str, float] = {}

    def __init__(self, path: Path) -> None:
        self._path, self.source = path, path_text(path)
        self._skipped, names = self._head()
        if len(names) > MOST_COLUMNS:
            raise SignalError(f"{self.source}: has {len(names)} columns: {MOST_COLUMNS} are read at most.")
        self._at: dict[str, int] = {}
        self._twice = {name for name in names if name and names.count(name) > 1}
        for i, name in enumerate(names):
            self._at.setdefault(name or f"column_{i + 1}", i)

    def _head(self) -> tuple[int, list[str]]:
        """How many lines stand before the first row of numbers, and the names of the columns."""
        comment, skipped = "", 0
        with self._lines() as lines:
            for line in lines:
                line = line.lstrip("\ufeff")
                if not line.lstrip().startswith(COMMENTS):
                    break
                comment, skipped = line.strip().lstrip("#% "), skipped + 1
            else:
                line = ""
        separator = line or comment
        delimiter = max(DELIMITERS, key=separator.count)
        self._delimiter = delimiter if delimiter in separator else " "
        cells, said = self._cells(line), self._cells(comment)
        if any(cell and not _is_number(cell) for cell in cells) and len(cells) > 1:
            return skipped + 1, cells
        if len(said) > 1 and (not cells or len(said) == len(cells)):
            return skipped, said
        if cells and all(_is_number(cell) for cell in cells):
            return skipped, [f"column_{i + 1}" for i in range(len(cells))]
        raise SignalError(
            f"{self.source}: holds neither names of columns, such as time, position, effort, nor rows of numbers."
        )

    def _cells(self, line: str) -> list[str]:
        if self._delimiter == " ":
            return line.split()
        return [cell.strip() for cell in next(csv.reader([line], delimiter=self._delimiter), [])]

    @property
    def columns(self) -> Collection[str]:
        """Names of the columns; of two alike the first."""
        return self._at

    def read(self, names: Collection[str]) -> dict[str, Floats]:
        """The columns (n,) of these names. Raises SignalError where two columns have one of them."""
        if twice := sorted(self._twice & set(names)):
            raise SignalError(f"{self.source}: two columns are called '{twice[0]}': rename one of them.")
        wanted = [self._at[name] for name in names]
        made: list[Floats] = []
        with self._lines() as lines:
            block: list[list[float]] = []
            rows = 0
            for cells in self._rows(itertools.islice(lines, self._skipped, None)):
                comma = self._delimiter != ","
                block.append([_number(cells[i], comma=comma) if i < len(cells) else math.nan for i in wanted])
                if len(block) >= ROWS:
                    rows += len(block)
                    refuse_large(self.source, rows, len(wanted))
                    made.append(np.array(block))
                    block = []
            refuse_large(self.source, rows + len(block), len(wanted))
            made.append(np.array(block).reshape(-1, len(wanted)))
        whole = np.concatenate(made)
        return {name: whole[:, i] for i, name in enumerate(names)}

    def _rows(self, lines: Iterator[str]) -> Iterator[list[str]]:
        if self._delimiter == " ":
            return (line.split() for line in lines)
        return csv.reader(lines, delimiter=self._delimiter, skipinitialspace=True)

    @contextmanager
    def _lines(self) -> Iterator[Iterator[str]]:
        try:
            with opened_file(self._path) as file:
                yield (decoded(line.rstrip(b"\r\n").replace(b"\t", b";")) for line in _lines(file, self.source))
        except OSError as error:
            raise SignalError(f"{self.source}: cannot be read ({error.strerror}).") from error
        except csv.Error as error:
            raise SignalError(f"{self.source}: is not a table ({error}).") from error


def _lines(file: io.BufferedReader, shown: str) -> Iterator[bytes]:
    while line := file.readline(LONGEST_LINE + 1):
        if len(line) > LONGEST_LINE:
            raise SignalError(f"{shown}: has a line of over {LONGEST_LINE} bytes: this is no table.")
        if line.strip():
            yield line


def _number(cell: str, *, comma: bool) -> float:
    """The number in a cell, NaN where it holds none; a comma within is the decimal point where it does not separate.

    Of a date or a time of day by ISO 8601: seconds since 1970, or since midnight.
    """
    text = cell.replace(",", ".") if comma else cell
    try:
        return float(text)
    except ValueError:
        return _seconds(text.strip()) if ":" in text else math.nan


def _seconds(text: str) -> float:
    """Seconds of a date and time since 1970, UTC where it names no zone, or of a time of day; NaN for another text."""
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        try:
            moment = datetime.combine(datetime(1970, 1, 1), time.fromisoformat(text))
        except ValueError:
            return math.nan
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _is_number(text: str) -> bool:
    return not math.isnan(_number(text, comma=True))
