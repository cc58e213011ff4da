"""`flex_ident compare`: results side by side; a difference counts when it exceeds both uncertainties."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from flex_ident.recording.names import path_text
from flex_ident.report.stored import stored_result
from flex_ident.report.table import rounded, text_table

BEYOND_CHANCE = 3.0


def compared(paths: Sequence[Path]) -> str:
    """A table of parameters by result, the difference of each from the first, and that in standard deviations."""
    results = [stored_result(p) for p in paths]
    first = results[0]
    keys = list(dict.fromkeys(p.key for r in results for p in r.parameters))
    header = ["parameter", "unit", *(_title(i) for i in range(len(results)))]
    for i in range(1, len(results)):
        header += [f"{_title(i)} - A", "σ"]
    rows = []
    for key in keys:
        found = [next((p for p in r.parameters if p.key == key), None) for r in results]
        unit = next(p.unit for p in found if p is not None)
        row = [key, unit]
        for p in found:
            other = "" if p is None or p.unit == unit else f" {p.unit}"
            row.append("-" if p is None else f"{rounded(p.value, p.std)} ± {rounded(2 * p.std, 2 * p.std)}{other}")
        base = found[0]
        for p in found[1:]:
            if base is None or p is None or base.unit != p.unit:
                row += ["-", "-"]
                continue
            difference, std = p.value - base.value, math.hypot(p.std, base.std)
            sigmas = abs(difference) / std if std > 0 else math.inf
            share = f" ({100 * difference / base.value:+.1f} %)" if base.value else ""
            mark = " *" if sigmas > BEYOND_CHANCE and math.isfinite(sigmas) else ""
            row += [f"{rounded(difference, std)}{share}", f"{sigmas:.1f}{mark}"]
        rows.append(row)
    lines = [
        f"{_title(i)}: {path_text(r.path)} ({r.joint}, {r.sensors}, {r.method}, {r.verdict})"
        for i, r in enumerate(results)
    ]
    if len({r.joint for r in results}) > 1:
        lines.append("these are results of different joints")
    lines += ["", text_table(header, rows, right=range(2, len(header))), ""]
    lines.append(f"values ± 2σ; * differs from {first.joint} in A by more than {BEYOND_CHANCE:.0f} standard deviations")
    return "\n".join(lines)


def _title(index: int) -> str:
    return chr(ord("A") + index) if index < 26 else str(index + 1)
