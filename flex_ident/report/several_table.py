"""Several recordings of one joint for a person at a terminal: the numbers together, then each recording's."""

from __future__ import annotations

import math

from flex_ident.notices import Notice
from flex_ident.report.sentences import sentence
from flex_ident.report.several_result import JoinedResult, weights
from flex_ident.report.table import parameter_row, rounded, text_table

IN_CURRENT = "Each recording's own values are in units of the current; those of all together are in N m."
HEADER = ("parameter", "value", "± 2σ", "%σ", "unit", "scatter", "")


def several_rows(joined: JoinedResult) -> list[tuple[str, ...]]:
    """A row a parameter: as that of one result, with what it scatters by between recordings where that is not zero."""
    found = joined.found
    rows: list[tuple[str, ...]] = []
    for p in found.parameters:
        key, value, two, share, unit, meaning = parameter_row(p, rigid=joined.results[0].model.rigid)
        size = ""
        if p.key in found.given.keys:
            own = found.pooled[found.given.keys.index(p.key)]
            tau = found.multiplied * own.scatter
            size = rounded(tau, tau) if tau > 0.0 else "-"
        rows.append((key, value, two, share, unit, size, meaning))
    return rows


def recording_rows(joined: JoinedResult) -> tuple[list[str], list[list[str]]]:
    """Header and a row a recording: name, verdict, weight in the stiffness or inertia, and each parameter ± 2σ."""
    found = joined.found
    keys = list(found.given.keys)
    chief = next((key for key in ("K", "JL", "J") if key in keys), keys[0])
    rows = []
    for i, (member, result) in enumerate(zip(found.members, joined.results, strict=True)):
        row = [member.name, result.verdict, f"{100.0 * weights(found, i)[chief]:.0f} %"]
        known = {p.key: p for p in result.parameters}
        for key in keys:
            p = known.get(key)
            if p is None or not p.identifiable or not math.isfinite(p.std):
                row.append("-")
            else:
                row.append(f"{rounded(p.value, p.std)} ± {rounded(2 * p.std, 2 * p.std)}")
        rows.append(row)
    return ["recording", "verdict", f"weight in {chief}", *keys], rows


def several_text(joined: JoinedResult) -> str:
    """The result: verdict, parameters, recordings, warnings."""
    found = joined.found
    count = len(joined.results)
    lines = [f"{joined.joint}: {found.verdict}  ({count} recordings together, sensors {joined.sensors})", ""]
    lines += [text_table(HEADER, several_rows(joined), right=(1, 2, 3, 5)), ""]
    header, rows = recording_rows(joined)
    lines += [text_table(header, rows, right=range(2, len(header))), ""]
    if joined.in_amperes and found.multiplied != 1.0:
        lines += [IN_CURRENT, ""]
    lines += [f"warning: {text}" for text in said(found.notices)]
    return "\n".join(lines)


def said(notices: tuple[Notice, ...]) -> list[str]:
    """The sentence of each notice once, those that doubt first."""
    first = sorted(notices, key=lambda n: n.severity == "info")
    return list(dict.fromkeys(sentence(n) for n in first))
