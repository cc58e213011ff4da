"""Truth beside estimate, for runs on the virtual joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flex_ident.parameters import JointModel
from flex_ident.report.table import rounded

HEADER = ("parameter", "truth", "estimate", "95 % interval", "unit", "inside")


def truth_rows_text(content: Mapping[str, Any], truth: JointModel) -> list[tuple[str, ...]]:
    """Rows of `HEADER` from the content of a `result.json`: does each 95 % interval hold the truth?"""
    rows: list[tuple[str, ...]] = []
    for key, p in content["parameters"].items():
        true, (low, high), std = truth.value(key), p["ci95"], p["std"]
        if not p["identifiable"] or low is None or std is None:
            inside, interval = "not identifiable", "-"
        else:
            inside = "yes" if low <= true <= high else "NO"
            interval = f"{rounded(low, std)} to {rounded(high, std)}"
        estimate = rounded(p["value"], std) if std is not None else f"{p['value']:.4g}"
        rows.append((key, f"{true:.6g}", estimate, interval, p["unit"], inside))
    return rows
