"""The rows of an archive's many files gathered in one, so that what is asked twice does not open each of them again.

It is a copy that can be removed at any time. Each row carries the name, size and time of its file: rows of files that
changed or went do not count, and files that are new are read and added.
"""

from __future__ import annotations

import os
import uuid
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from flex_ident.bags.extras import extra_module

GATHERED, ASIDE = ".gathered_rows", ".aside_"
"""No file of the table: its name begins with a dot and has no suffix."""
FEWEST = 200
"""Files from which rows are gathered: fewer are opened faster than one notices."""
STATE = ("file", "size", "changed_ns")


def gathered_table(files: Sequence[Path], columns: Sequence[str], kept: Sequence[str], schema: Any, extra: str) -> Any:
    """Those `columns` of the rows of all `files`, in their order. Of `kept` columns all are kept for the next time.

    Raises OSError and ValueError (pyarrow's own errors are one or the other) where a file cannot be read.
    """
    arrow, parquet, data, compute = (
        extra_module(name, extra, "Archives of many recordings")
        for name in ("pyarrow", "pyarrow.parquet", "pyarrow.dataset", "pyarrow.compute")
    )
    states = {str(file.name): file.stat() for file in files}
    own = arrow.schema([*(schema.field(name) for name in kept), *_state_fields(arrow)])
    place = files[0].parent / GATHERED
    known = _valid(parquet, compute, arrow, place, own, states)
    there = set() if known is None else set(known.column("file").unique().to_pylist())
    new = [file for file in files if file.name not in there]
    if new:
        table = data.dataset([str(f) for f in new], schema=schema, format="parquet").to_table([*kept, "__filename"])
        names = [os.path.basename(name) for name in table.column("__filename").to_pylist()]
        for field, values in zip(
            _state_fields(arrow),
            (names, [states[n].st_size for n in names], [states[n].st_mtime_ns for n in names]),
            strict=True,
        ):
            table = table.append_column(field, arrow.array(values, field.type))
        fresh = table.select(own.names).cast(own)
        known = fresh if known is None else arrow.concat_tables([known, fresh])
        known = known.take(compute.sort_indices(known.column("file")))
        with suppress(OSError):  # of an archive that one may only read nothing is kept
            _write(parquet, known, place)
    return known.select(list(columns))


def _state_fields(arrow: Any) -> list[Any]:
    return [arrow.field(name, arrow.string() if name == "file" else arrow.int64()) for name in STATE]


def _valid(parquet: Any, compute: Any, arrow: Any, place: Path, own: Any, states: dict[str, os.stat_result]) -> Any:
    """The rows gathered before of files that are as they were; None where there are none."""
    try:
        table = parquet.read_table(place, partitioning=None)
    except (OSError, ValueError):
        return None
    if not table.schema.equals(own):
        return None
    rows = zip(*(table.column(name).to_pylist() for name in STATE), strict=True)
    same = [
        (s := states.get(file)) is not None and s.st_size == size and s.st_mtime_ns == changed
        for file, size, changed in rows
    ]
    return table if all(same) else table.filter(arrow.array(same))


def _write(parquet: Any, table: Any, place: Path) -> None:
    aside = place.with_name(f"{ASIDE}{uuid.uuid4().hex}")
    try:
        parquet.write_table(table, aside, compression="zstd")
        os.replace(aside, place)
    finally:
        aside.unlink(missing_ok=True)
