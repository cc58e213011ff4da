"""The explanation of several recordings for a person at a terminal."""

from __future__ import annotations

from flex_ident.notices import Code, Notice
from flex_ident.report.gap_set_result import OTHERS, JoinedGap, SetEffect
from flex_ident.report.gap_set_worded import evidence_text, reason_text
from flex_ident.report.gap_table import change
from flex_ident.report.several_table import HEADER, IN_CURRENT, said, several_rows
from flex_ident.report.table import rounded, text_table

SUMMARY = {
    "complete": "no effect shows that is missing in any recording: what is left of the gaps is noise",
    "explained": "what was missing is named and holds in recordings that it was not taken from; the rest is noise",
    "partly_explained": "something was missing and is named, but a gap remains in some of the recordings",
    "unexplained": "a gap remains that no effect accounts for which holds over the recordings",
    "rejected": "together the recordings do not determine the joint",
}
SAID = {"confirms": "falls", "contradicts": "grows", "cannot_tell": "does not tell", "not_tried": "not tried"}
"""What the gap of a recording does with the values of the others."""


def size_text(result: JoinedGap, effect: SetEffect) -> str:
    """An effect's parameters over all recordings, with what they scatter by and whether they agree."""
    parts = []
    for p, own, _ in result.pooled(effect):
        text = f"{p.key.partition('.')[2]} {rounded(p.value, p.std)} ± {rounded(2 * p.std, 2 * p.std)} {p.unit}"
        text = text.removesuffix(" 1").rstrip()
        if own is not None and own.weights.size > 1:
            text += f" (chance of the recordings' differences {own.chance:.2g})"
        parts.append(text)
    return ", ".join(parts)


def effect_rows(result: JoinedGap) -> tuple[list[str], list[list[str]]]:
    """Header and a row an effect and recording: found by itself, its first size there, the gap with others' values."""
    header = ["effect", "recording", "found", "size", "gap before", "others' values", "their verdict"]
    rows = []
    for own in result.effects:
        for name, heard, finding in zip(result.names, own.heard, own.proposal.findings, strict=True):
            size = "-"
            if finding is not None:
                p = finding.parameters[0]
                size = f"{rounded(p.value, p.std)} ± {rounded(2 * p.std, 2 * p.std)} {p.unit}".rstrip()
            tried = heard.said != "not_tried"
            rows.append([
                own.proposal.effect, name, "yes" if heard.found else "no", size,
                f"{heard.before:.3g}" if tried else "-", f"{heard.after:.3g}" if tried else "-", SAID[heard.said],
            ])  # fmt: skip
    return header, rows


def gap_rows(result: JoinedGap) -> tuple[list[str], list[list[str]]]:
    """Header and a row a recording: what it says by itself, its gap before and after, and its noise."""
    unit = result.unit
    header = ["recording", "by itself", f"gap, {unit}", "after", "change", "noise floor", "effects' values from"]
    rows = [
        [name, own.verdict.replace("_", " "), f"{gap.before:.3g}", f"{gap.after:.3g}", change(gap.before, gap.after),
         f"{gap.floor:.3g}", "the others" if gap.values_from == OTHERS else "itself"]
        for name, own, gap in zip(result.names, result.own, result.gaps, strict=True)
    ]  # fmt: skip
    return header, rows


def gap_set_text(result: JoinedGap) -> str:
    """Verdict, gaps, effects, what was not accepted, parameters, warnings."""
    joined = result.joined
    count = len(result.names)
    lines = [
        f"{joined.joint}: {result.verdict.replace('_', ' ')}: {SUMMARY[result.verdict]}  ({count} recordings together, "
        f"sensors {joined.sensors})", "",
    ]  # fmt: skip
    steps = [(name, f"{gap:.4g}") for name, gap in result.steps]
    steps.append(("noise floor", f"{result.rms([own.floor for own in result.gaps]):.4g}"))
    lines += [text_table(("model", f"gap, {result.unit} rms, {result.measured_on}"), steps, right=(1,)), ""]
    header, rows = gap_rows(result)
    lines += [text_table(header, rows, right=(2, 3, 4, 5))]
    for own in result.accepted:
        lines += ["", f"{own.proposal.effect}: {size_text(result, own)}"]
        lines.append(f"  {evidence_text(own.proposal, own.heard, result.names)}")
    refused = [own for own in result.effects if not own.accepted]
    if refused:
        lines += ["", "not accepted:"]
        lines += [f"  {reason_text(own.proposal, own.heard, own.outcome, result.names)}" for own in refused]
    if result.effects:
        header, rows = effect_rows(result)
        lines += ["", text_table(header, rows, right=(4, 5))]
    if result.left:
        lines += ["", *(f"unexplained in {text}" for text in result.left)]
    lines += ["", text_table(HEADER, several_rows(joined), right=(1, 2, 3, 5)), ""]
    if joined.in_amperes and joined.found.multiplied != 1.0:
        lines += [IN_CURRENT, ""]
    lines += [f"note: {text}" for text in said(notes(result))]
    return "\n".join(lines)


def notes(result: JoinedGap) -> tuple[Notice, ...]:
    """What else there is to say of the set; that single explanations doubt is in their verdicts."""

    hidden = (Code.RECORDINGS_DOUBTFUL, Code.EFFECT_NOT_SHARED)
    return tuple(n for n in result.joined.found.notices if n.code not in hidden)
