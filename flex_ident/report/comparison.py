"""`flex_ident compare`: results side by side, one by one and over all parameters together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flex_ident.parameters import Parameter
from flex_ident.pooling.agreement import Agreement, agreement
from flex_ident.recording import Floats
from flex_ident.recording.names import path_text
from flex_ident.report.stored import StoredResult, stored_result
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
    lines += [f"A and {_title(i)}: {joint_text(first, results[i])}" for i in range(1, len(results))]
    lines.append(f"values ± 2σ; * differs from {first.joint} in A by more than {BEYOND_CHANCE:.0f} standard deviations")
    return "\n".join(lines)


def joint_agreement(one: StoredResult, other: StoredResult) -> Agreement | None:
    """Whether two results agree over all parameters that both determine; None where that cannot be judged.

    Of results of one recording it cannot: their difference is no chance.
    """
    keys, known = _shared(one, other)
    if not keys or one.recordings & other.recordings:
        return None
    difference = np.array([known[1][key].value - known[0][key].value for key in keys])
    own = [_own_covariance(r, [p[k].std for k in keys], keys) for r, p in zip((one, other), known, strict=True)]
    return agreement(keys, difference, own[0] + own[1])


def _shared(one: StoredResult, other: StoredResult) -> tuple[list[str], list[dict[str, Parameter]]]:
    """The keys of the parameters that both determine in one unit, and each one's parameters by key."""
    known = [{p.key: p for p in r.parameters if p.identifiable and 0.0 < p.std < math.inf} for r in (one, other)]
    keys = [key for key in known[0] if key in known[1] and known[0][key].unit == known[1][key].unit]
    return keys, known


def joint_text(one: StoredResult, other: StoredResult) -> str:
    """Whether two results agree over all parameters that both determine, in a sentence."""
    if one.recordings & other.recordings:
        return "of the same recording, or one that both hold: how far they differ cannot be judged by chance."
    keys, known = _shared(one, other)
    found = joint_agreement(one, other)
    if found is None:
        units = sorted({(known[0][k].unit, known[1][k].unit) for k in known[0] if k in known[1]})
        if units:
            pairs = ", ".join(f"{a} and {b}" for a, b in units[:3])
            return f"what both determine is in different units ({pairs}): one effort is a current, or one joint slides."
        return "no parameter is determined in both."
    missing = [r for r in (one, other) if r.covariance is None]
    alone = " (errors taken as independent: there is no covariance in it)" if missing else ""
    numbers = f"chi-square {found.chi_square:.1f} over {found.freedom} (chance {found.chance:.2g})"
    shared = f"{len(keys)} shared parameter{'s' if len(keys) > 1 else ''} together"
    if found.agree:
        return f"agree over {shared}: {numbers}{alone}."
    return f"do NOT agree over {shared}: {numbers}, most by {found.farthest}{alone}."


def _own_covariance(result: StoredResult, stds: list[float], keys: list[str]) -> Floats:
    """The covariance (p, p) of a result's `keys`: the one stored for those that it holds, else of each alone."""
    matrix = np.diag(np.square(stds))
    if result.covariance is not None:
        at = [i for i, key in enumerate(keys) if key in result.covariance.keys]
        matrix[np.ix_(at, at)] = result.covariance.of([keys[i] for i in at])
    return matrix


def _title(index: int) -> str:
    return chr(ord("A") + index) if index < 26 else str(index + 1)
