"""The archive: a folder of Parquet files, one a recording, named after what was asked of which bytes.

A file is written aside and takes its place by renaming: it is there whole or not at all, whatever is killed when, and
what was asked twice has one file.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import time
import uuid
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from flex_ident import __version__
from flex_ident.bags.extras import extra_module
from flex_ident.errors import DataError
from flex_ident.fleet.gathered import FEWEST, gathered_table
from flex_ident.fleet.rows import ARCHIVE, COLUMNS, FLAGS, NUMBERS, TIMES, Row
from flex_ident.recording.names import path_text
from flex_ident.report.folder import check_writable, write_file

EXTRA, WHAT = "fleet", "Archives of many recordings"
SUFFIX, ASIDE = ".parquet", ".aside_"
STALE_S = 3600.0
"""Age from which a file aside is taken for one that a killed worker left."""
SMALL: Mapping[str, Any] = {"compression": "zstd", "use_dictionary": False, "write_statistics": False}
"""How to write a file of one row: half as large as by default."""
WIDE = ("result",)
"""Columns that are no use in a spreadsheet."""


class Archive:
    """A folder of results. Raises MissingExtraError without pyarrow."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._arrow = extra_module("pyarrow", EXTRA, WHAT)
        self._parquet = extra_module("pyarrow.parquet", EXTRA, WHAT)

    def opened(self) -> Archive:
        """Itself, with its folder made and what killed workers left aside removed. Raises UsageError."""
        check_writable(self.folder, "--archive")
        self.folder.mkdir(parents=True, exist_ok=True)
        for path in self.folder.glob(f"{ASIDE}*"):
            with suppress(OSError):
                if time.time() - path.stat().st_mtime > STALE_S:
                    path.unlink()
        return self

    def file_of(self, sha256: str, settings: Mapping[str, Any]) -> Path:
        """Where the results go of a recording with these settings, by this version."""
        asked = json.dumps([settings, __version__], sort_keys=True)
        return self.folder / f"{sha256[:24]}_{hashlib.sha256(asked.encode()).hexdigest()[:16]}{SUFFIX}"

    def rows_in(self, file: Path) -> list[Row]:
        """The rows of one file; none where it is not there or is damaged."""
        if not file.is_file():
            return []
        try:
            rows: list[Row] = self._parquet.read_table(file, partitioning=None).to_pylist()
        except (OSError, ValueError):  # pyarrow's own errors are one or the other
            return []
        return rows if all(row.get("archive") == ARCHIVE for row in rows) else []

    def write(self, file: Path, rows: Sequence[Row]) -> None:
        """Write the rows of one recording, at once or not at all. Raises OSError."""
        table = self._arrow.Table.from_pylist(list(rows), schema=self._schema())
        aside = file.with_name(f"{ASIDE}{uuid.uuid4().hex}")
        try:
            with aside.open("wb") as handle:
                self._parquet.write_table(
                    table, handle, compression="zstd", use_dictionary=False, write_statistics=False
                )
                handle.flush()
                os.fsync(handle.fileno())
            os.replace(aside, file)
        finally:
            aside.unlink(missing_ok=True)

    def rows(self, columns: Sequence[str] = COLUMNS) -> list[Row]:
        """All rows of the archive, files in the order of their names. Raises DataError where it is none."""
        rows: list[Row] = self._table(columns).to_pylist()
        return rows

    def write_csv(self, file: Path) -> None:
        """The archive as one table for a spreadsheet. Raises DataError and UsageError."""
        table = self._table([name for name in COLUMNS if name not in WIDE])
        content = io.BytesIO()
        extra_module("pyarrow.csv", EXTRA, WHAT).write_csv(table, content)
        write_file(file, content.getvalue(), "--csv")

    def _table(self, columns: Sequence[str]) -> Any:
        """Those columns of all files: of 10,000, what is not asked for is most of what there is to read."""
        files = sorted(self.folder.glob(f"*{SUFFIX}"))
        shown = path_text(self.folder)
        odd = next((file for file in files if not file.is_file()), None)
        if odd is not None:  # a pipe would be waited for
            raise DataError(f"{path_text(odd)}: is no file; remove it.")
        if not files:
            raise DataError(f"{shown}: no archive: no {SUFFIX} file is there. flex_ident batch makes one.")
        try:  # at once; which file is at fault is found out only where one is
            data = extra_module("pyarrow.dataset", EXTRA, WHAT)
            asked = list(dict.fromkeys((*columns, "archive")))
            if len(files) >= FEWEST and not set(columns) & set(WIDE):
                kept = [name for name in COLUMNS if name not in WIDE]
                table = gathered_table(files, asked, kept, self._schema(), EXTRA)
            else:
                table = data.dataset([str(f) for f in files], schema=self._schema(), format="parquet").to_table(asked)
            if set(table.column("archive").unique().to_pylist()) == {ARCHIVE}:
                return table.select(list(columns))
        except (OSError, ValueError):  # pyarrow's own errors are one or the other
            pass
        return self._arrow.concat_tables([self._read(file, columns) for file in files])

    def _read(self, file: Path, columns: Sequence[str]) -> Any:
        """Those columns of one file. Raises DataError."""
        try:
            with self._parquet.ParquetFile(file) as opened:
                known = opened.schema_arrow.equals(self._schema())
                table = opened.read(columns=list(columns)) if known else None
        except (OSError, ValueError) as error:
            raise DataError(f"{path_text(file)}: is damaged; remove it, and batch does it again.") from error
        if table is None:
            raise DataError(f"{path_text(file)}: is not of an archive of this version ({ARCHIVE}).")
        return table

    def _schema(self) -> Any:
        arrow = self._arrow
        kinds = {
            **dict.fromkeys(COLUMNS, arrow.string()), **dict.fromkeys(TIMES, arrow.timestamp("us", tz="UTC")),
            **dict.fromkeys(FLAGS, arrow.bool_()), **dict.fromkeys(NUMBERS, arrow.float64()),
        }  # fmt: skip
        return arrow.schema([(name, kinds[name]) for name in COLUMNS])
