"""The tables of `flex_ident check-bag`."""

from __future__ import annotations

from collections.abc import Sequence

MOST_ROWS = 256
"""Topics, and joints, that are listed."""


def messages_text(count: int) -> str:
    """So many messages, in words."""
    return f"{count} message{'' if count == 1 else 's'}"


def first_rows(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """The lines of a table, or of its first rows, and how many more there are."""
    return table_lines(rows[:MOST_ROWS]) + ([f"  and {len(rows) - MOST_ROWS} more"] if len(rows) > MOST_ROWS else [])


def table_lines(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows in columns, two spaces apart, indented."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))] if rows else []
    return [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
