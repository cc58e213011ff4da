"""`report.html` of several recordings' explanation: which effects hold for the joint, and where."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flex_ident.effects import effect_named
from flex_ident.report.advice import begun
from flex_ident.report.figures import LINK, PREDICTED, QUIET, embedded, png_bytes, styled_figure
from flex_ident.report.gap_set_result import JoinedGap, SetEffect
from flex_ident.report.gap_set_table import SUMMARY, effect_rows, gap_rows, notes, size_text
from flex_ident.report.gap_set_worded import evidence_text, reason_text
from flex_ident.report.gap_table import change
from flex_ident.report.page import Image, Merit, Row, Section, page_html
from flex_ident.report.several_table import HEADER, said, several_rows

TWO_STAGES = (
    "Each recording is explained by itself first; then the effects that the others found are tried on it with the "
    "others' values, only the joint's base model fitted. It is no single fit of all recordings."
)


def gap_set_html(result: JoinedGap, figures: Mapping[str, bytes]) -> str:
    """One page: verdict, gaps of recordings left out, effects, what was not accepted, parameters, recordings."""
    joined = result.joined
    before, after = (result.rms(x) for x in ([g.before for g in result.gaps], [g.after for g in result.gaps]))
    merits = [
        Merit("gap before", f"{before:.3g} {result.unit}", f"rms, {result.measured_on}"),
        Merit("gap after", f"{after:.3g} {result.unit}", change(before, after)),
        Merit("noise floor", f"{result.rms([g.floor for g in result.gaps]):.3g} {result.unit}", "cannot be beaten"),
        Merit("recordings", str(len(result.names)), "each explained by itself first"),
    ]
    told = said(notes(result))
    header, rows = gap_rows(result)
    sections = [
        *([Section("Notes and warnings", items=tuple(told))] if told else []),
        Section(
            "The gap of each recording", header=tuple(header), rows=tuple(Row(tuple(row)) for row in rows),
            right=(2, 3, 4, 5), images=(Image(embedded(figures["gap_recordings"]), "gap of each recording"),),
            notes=(TWO_STAGES,),
        ),
        *(_found(result, own) for own in result.accepted),
        *_refused(result),
        *([Section("Not explained", items=tuple(result.left))] if result.left else []),
        *_effects(result),
        Section(
            "Parameters of all recordings together", header=HEADER, right=(1, 2, 3, 5),
            rows=tuple(
                Row(row, not p.identifiable)
                for row, p in zip(several_rows(joined), joined.found.parameters, strict=True)
            ),
            images=(Image(embedded(figures["recordings"]), "values of each recording with intervals"),),
            notes=(
                "Scatter: one standard deviation between recordings beyond what each says of itself. Points: each "
                "recording with its 95 % interval. Band: all together.",
            ),
        ),
    ]  # fmt: skip
    return page_html(
        title=f"{joined.joint}: the gap of {len(result.names)} recordings",
        heading=f"{joined.joint}: what the model lacks", verdict=result.verdict,
        summary=SUMMARY[result.verdict].capitalize() + ".", merits=merits, sections=sections,
        source=f"Recordings: {', '.join(result.names)}. Each one's own page is in the folder of its name.",
    )  # fmt: skip


def _found(result: JoinedGap, own: SetEffect) -> Section:
    evidence = evidence_text(own.proposal, own.heard, result.names)
    items = [f"Equation: {effect_named(own.proposal.effect).equation}", begun(evidence)]
    return Section(f"Found: {own.proposal.effect.replace('_', ' ')}", (size_text(result, own),), tuple(items))


def _refused(result: JoinedGap) -> list[Section]:
    items = tuple(
        reason_text(own.proposal, own.heard, own.outcome, result.names) for own in result.effects if not own.accepted
    )
    return [Section("Found in some recordings and not accepted", items=items)] if items else []


def _effects(result: JoinedGap) -> list[Section]:
    header, rows = effect_rows(result)
    if not rows:
        return []
    return [
        Section(
            "What each recording says of each effect", header=tuple(header),
            rows=tuple(Row((row[0].replace("_", " "), *row[1:]), row[2] == "no") for row in rows), right=(4, 5),
            notes=("Others' values: the gap, N m rms on data not fitted, with the effect as the others found it.",),
        )
    ]  # fmt: skip


def gaps_plot(result: JoinedGap) -> bytes:
    """Each recording's gap before and after, beside its noise floor."""
    count = len(result.names)
    with styled_figure(8.6, 0.5 * count + 1.1) as figure:
        axes = figure.subplots()
        at = np.arange(count)
        axes.barh(at - 0.19, [g.before for g in result.gaps], height=0.36, color=PREDICTED, label="base model")
        axes.barh(at + 0.19, [g.after for g in result.gaps], height=0.36, color=LINK, label="with what was accepted")
        for i, gap in enumerate(result.gaps):
            label = "noise floor" if i == 0 else None
            axes.plot([gap.floor] * 2, [i - 0.42, i + 0.42], color=QUIET, lw=2.0, label=label)
        axes.set_yticks(at, result.names)
        axes.invert_yaxis()
        axes.set_xlabel(f"gap, {result.unit} rms")
        axes.set_xlim(0.0, 1.04 * max(max(g.before, g.after) for g in result.gaps))
        figure.legend(loc="outside upper left", ncols=3)
        return png_bytes(figure)
