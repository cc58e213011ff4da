"""Truth beside estimate, for runs on the virtual joint."""

from __future__ import annotations

from flex_ident.parameters import Identification, JointModel
from flex_ident.report.table import rounded, text_table


def truth_table(result: Identification, truth: JointModel) -> str:
    """Each parameter's truth, estimate, 95 % interval, and whether the interval holds the truth."""
    rows = []
    for p in result.parameters:
        low, high = p.interval
        true = truth.value(p.key)
        inside = "yes" if low <= true <= high else "NO"
        if not p.identifiable:
            inside = "not identifiable"
        interval = f"{rounded(low, p.std)} to {rounded(high, p.std)}"
        rows.append((p.key, f"{true:.6g}", rounded(p.value, p.std), interval, p.unit, inside))
    return text_table(("parameter", "truth", "estimate", "95 % interval", "unit", "inside"), rows, right=(1, 2, 3))
