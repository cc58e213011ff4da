"""Bags that were replaced by others under the same name: the rows of what is there no more do not count."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from flex_ident.fleet.rows import Row
from flex_ident.pooling.thresholds import SESSION_S


def without_replaced(rows: Iterable[Row]) -> tuple[list[Row], list[dict[str, Any]]]:
    """The rows without those of bags whose path now has another hash, and of each such bag how many recordings went.

    A bag of one name that was recorded on another day is another recording, and both count: a name like `latest` is
    written again and again. The result that was finished last says what is there.
    """
    rows = list(rows)
    by_path: dict[str, list[Row]] = {}
    for row in rows:
        by_path.setdefault(row["bag"], []).append(row)
    gone: set[tuple[str, str]] = set()
    replaced = []
    for bag, own in by_path.items():
        newest: dict[str, Row] = {}
        for row in own:
            if row["sha256"] not in newest or newest[row["sha256"]]["finished_at"] < row["finished_at"]:
                newest[row["sha256"]] = row
        last = sorted(newest.values(), key=lambda row: row["finished_at"], reverse=True)
        kept: list[Row] = []
        for row in last:
            (kept if not any(_same_recording(row, other) for other in kept) else []).append(row)
        left = {row["sha256"] for row in last} - {row["sha256"] for row in kept}
        gone |= {(bag, sha256) for sha256 in left}
        if left:
            replaced.append({"bag": bag, "robot": last[0]["robot"], "recordings": len(left)})
    return [row for row in rows if (row["bag"], row["sha256"]) not in gone], replaced


def _same_recording(one: Row, other: Row) -> bool:
    """Whether two bags of one name may be two states of one recording: made on one day, or nobody knows when."""
    if one["recorded_at"] is None or other["recorded_at"] is None:
        return True
    return bool(abs((one["recorded_at"] - other["recorded_at"]).total_seconds()) <= SESSION_S)
