"""`report.html` of several recordings of one joint: each one's values and intervals beside those of all together."""

from __future__ import annotations

import numpy as np

from flex_ident.pooling.torque_scale import Estimate, TorqueScale
from flex_ident.report.figures import MEASURED, PREDICTED, QUIET, embedded, png_bytes, styled_figure
from flex_ident.report.page import Image, Merit, Row, Section, page_html
from flex_ident.report.several_result import JoinedResult, torque_constant
from flex_ident.report.several_table import HEADER, IN_CURRENT, recording_rows, said, several_rows
from flex_ident.report.table import rounded

SUMMARIES = {
    "trusted": "The recordings agree within what each says of itself and what scatters between them, which is in the "
    "intervals.",
    "doubtful": "The numbers can be used, but read the warnings first.",
    "rejected": "Do not use these numbers: together, the recordings do not determine them.",
}
HEADLINES = ("K", "Jm", "JL", "J", "FV", "FS")


def several_html(joined: JoinedResult, figures: dict[str, bytes]) -> str:
    """One page: verdict, warnings, parameters, a picture of every recording's values, scatter, recordings."""
    found = joined.found
    merits = [
        Merit(p.key, f"{rounded(p.value, p.std)} {p.unit}", f"± {rounded(2 * p.std, 2 * p.std)} (2σ)")
        for key in HEADLINES for p in found.parameters if p.key == key and p.identifiable
    ][:4]  # fmt: skip
    sections = [
        *([Section("Warnings and what to do", items=tuple(said(found.notices)))] if found.notices else []),
        Section(
            "Parameters of all recordings together", header=HEADER, right=(1, 2, 3, 5),
            rows=tuple(
                Row(row, not p.identifiable) for row, p in zip(several_rows(joined), found.parameters, strict=True)
            ),
            notes=("Scatter: one standard deviation between recordings beyond what each says of itself.",),
        ),
        Section(
            "Each recording beside all together",
            images=(Image(embedded(figures["recordings"]), "values of each recording with intervals"),),
            notes=("Points: each recording with its 95 % interval. Band: all together. Hollow: disagrees.",),
        ),
        *_scale(found.scale, current=joined.in_amperes),
        *_causes(joined),
        _recordings(joined),
    ]  # fmt: skip
    return page_html(
        title=f"{joined.joint}: {len(joined.results)} recordings", heading=joined.joint, verdict=found.verdict,
        summary=SUMMARIES[found.verdict], merits=merits, sections=sections,
        source=f"{len(joined.results)} recordings, each identified by itself and then put together. SI units, link "
        "side of the gear.",
    )  # fmt: skip


def _scale(scale: TorqueScale | None, *, current: bool) -> list[Section]:
    if scale is None or scale.both is None:
        return []
    unit = torque_constant(scale, current=current)["unit"]
    rows = tuple(
        Row((name, f"{own.value:.5g}", f"{own.low:.5g} to {own.high:.5g}", unit))
        for name, own in (
            ("by inertia", scale.inertia), ("by gravity", scale.gravity), ("together", scale.both),
        ) if isinstance(own, Estimate)
    )  # fmt: skip
    agree = {True: "Both say the same.", False: "They do not agree.", None: "Only one of them tells."}[scale.agree]
    return [
        Section(
            "The effort's scale, by the known mass", (agree,), header=("", "scale", "95 % interval", "unit"), rows=rows,
            right=(1, 2), notes=("What the recorded effort must be multiplied by. No friction is in it.",),
        )
    ]  # fmt: skip


def _causes(joined: JoinedResult) -> list[Section]:
    rows = tuple(
        Row((c.key, c.condition, f"{100 * c.share:.0f} %", f"{c.chance:.2g}", ", ".join(c.alike) or "-"))
        for c in joined.found.causes
    )
    if not rows:
        return []
    header = ("parameter", "condition", "accounts for", "chance", "not told from")
    return [Section("What scatter follows", header=header, rows=rows, right=(2, 3))]


def _recordings(joined: JoinedResult) -> Section:
    header, rows = recording_rows(joined)
    conditions = [member.conditions for member in joined.found.members]
    names = list(dict.fromkeys(name for own in conditions for name in own))
    notes = [IN_CURRENT] if joined.in_amperes and joined.found.multiplied != 1.0 else []
    for member, own in zip(joined.found.members, conditions, strict=True):
        shown = ", ".join(
            f"{n} {own[n]:.4g}" if isinstance(own[n], float) else f"{n} {own[n]}" for n in names if n in own
        )
        notes += [f"{member.name}: {shown}."] if shown else []
    return Section(
        "The recordings", header=tuple(header), rows=tuple(Row(tuple(row)) for row in rows),
        right=tuple(range(2, len(header))), notes=tuple(notes),
    )  # fmt: skip


def recordings_plot(joined: JoinedResult) -> bytes:
    """A panel a parameter: every recording's value with its interval, and the band of all together."""
    found = joined.found
    keys = found.given.keys
    columns = min(3, len(keys))
    rows = -(-len(keys) // columns)
    names = [member.name for member in found.members]
    apart = {own.index for own in found.disagreements}
    with styled_figure(8.6, rows * (0.9 + 0.2 * len(names)) + 0.3) as figure:
        axes = np.atleast_1d(figure.subplots(rows, columns)).ravel()
        for k, key in enumerate(keys):
            a, own = axes[k], found.pooled[k]
            a.axvspan(own.value - own.half, own.value + own.half, color=PREDICTED, alpha=0.15, lw=0)
            a.axvline(own.value, color=PREDICTED, lw=1.0)
            for i in range(len(names)):
                if not found.given.there[i, k]:
                    continue
                value, std = found.given.values[i, k], np.sqrt(found.given.covariances[i, k, k])
                face = "white" if i in apart else MEASURED
                a.errorbar(value, i, xerr=1.96 * std, fmt="o", ms=4, color=MEASURED, mfc=face, ecolor=QUIET)
            unit = next((p.unit for p in joined.results[0].parameters if p.key == key), "")
            a.set_title(f"{key}, {unit}" if unit and not joined.in_amperes else key)
            a.set_yticks(range(len(names)), names if k % columns == 0 else [""] * len(names))
            a.set_ylim(len(names) - 0.5, -0.5)
            a.locator_params(axis="x", nbins=4)
        for a in axes[len(keys) :]:
            a.set_visible(False)
        return png_bytes(figure)
