"""An explained gap for a person at a terminal."""

from __future__ import annotations

from dataclasses import replace

from flex_ident.effects import effect_named
from flex_ident.gap.explanation import Finding, GapExplanation
from flex_ident.likelihood.thresholds import STRUCTURE
from flex_ident.notices import Code, Why
from flex_ident.parameters import Identification
from flex_ident.report.advice import first_thing, other_things, told
from flex_ident.report.gap_words import evidence_text, reading_text, region_text, rejected_text, unexplained_text
from flex_ident.report.table import rounded, text_table
from flex_ident.report.units import Words, words_of

SUMMARY = {
    "complete": "no effect shows that is missing: what is left of the gap is noise",
    "explained": "what was missing is named, and the rest is noise",
    "partly_explained": "something was missing and is named, but a gap remains",
    "unexplained": "a gap remains that no effect of the catalogue accounts for",
    "rejected": "the base model does not describe this recording at all",
}
WITHIN_OWN_ERROR = {
    "complete": "no effect shows that is missing: what is left is more than noise ({floor:.3g} {unit}), and no more "
    "than the method's own error ({own:.3g} {unit})",
    "explained": "what was missing is named; the rest is more than noise ({floor:.3g} {unit}), and no more than the "
    "method's own error ({own:.3g} {unit})",
}
"""The same where not all that is left is noise."""
SUSPECTED = (Why.CAUSE_SUSPECTED, Why.SCALE_SUSPECTED)
SUSPECTED_ONLY = "what is left is no more than noise, and an effect is suspected all the same"
GRANTED = (
    Code.LINK_TAKEN_AS_RIGID,
    Code.GRAVITY_TAKEN_ALONE,
    Code.ENCODER_TAKEN_AS_TRUE,
    Code.SLOPE_TAKEN_ON_LINK,
    Code.LOSS_UNSEEN,
)
"""What the model takes for granted where the recording cannot show it."""
GRANTED_BELOW = "; what the recording cannot show and the model takes for granted is said below"


def summary_text(e: GapExplanation) -> str:
    """What the verdict means; and, where all is noise, that this rests on what the recording cannot show."""
    if e.unexplained and all(reason.why in SUSPECTED for reason in e.unexplained) and e.verdict == "unexplained":
        return SUSPECTED_ONLY
    granted = e.verdict in ("complete", "explained") and any(n.code in GRANTED for n in e.final.notices)
    text = SUMMARY[e.verdict]
    if e.verdict in WITHIN_OWN_ERROR and e.after > STRUCTURE * e.noise_floor:
        text = WITHIN_OWN_ERROR[e.verdict].format(floor=e.noise_floor, own=e.method_error, unit=e.unit)
    return text + (GRANTED_BELOW if granted else "")


def finding_text(finding: Finding, words: Words) -> str:
    """An effect with its numbers, in one line."""
    numbers = ", ".join(
        f"{p.key} {rounded(p.value, p.std)} ± {rounded(2 * p.std, 2 * p.std)} {p.unit}".removesuffix(" 1").rstrip()
        for p in finding.parameters
    )
    if finding.curve is not None:
        numbers = reading_text(finding, words)
    how = "put in by hand" if finding.verdict == "by_hand" else f"confidence {finding.confidence:.2f}"
    return f"{finding.effect}: {effect_named(finding.effect).summary} ({numbers}; {how})"


def others_text(finding: Finding) -> str:
    """What else was considered, each with the gap that it would have left, and what a larger one than before means."""
    said = [f"{a.effect} (gap {a.gap_after:.3g})" for a in finding.also_considered]
    worse = [a.effect for a in finding.also_considered if a.gap_after > finding.gap_before]
    if not worse:
        return ", ".join(said)
    one = "that" if len(worse) == 1 else "those"
    return (
        f"{', '.join(said)}; a gap above {finding.gap_before:.3g} is larger than without {one}: a fit weighs each "
        "frequency by its noise, and may lose in rms what it gains there"
    )


def change(before: float, after: float, digits: int = 0) -> str:
    """The change in percent with its sign, as text; `±0` where it rounds to nothing."""
    if before <= 0.0:
        return ""
    text = f"{100 * (after / before - 1):+.{digits}f}"
    return f"{text} %" if text.strip("+-0.") else "±0 %"


def closed_share(share: float) -> str:
    """The share of the gap that an effect would close, in percent, as text."""
    return "makes it worse" if share <= -0.005 else f"{100 * min(1.0, max(0.0, share)):.0f}"


def do_first(explanation: GapExplanation) -> str | None:
    """The one thing to do where the base model does not describe the recording."""
    return first_thing(_final(explanation)) if explanation.verdict == "rejected" else None


def warnings_of(explanation: GapExplanation) -> tuple[str, ...]:
    """What speaks against the recording and the final model, each once, the most important first."""
    final = _final(explanation)
    first = None if explanation.verdict == "rejected" else first_thing(final)
    said = told(explanation.notices)
    return tuple(t for t in (*([first] if first else []), *other_things(final)) if t not in said)


def _final(explanation: GapExplanation) -> Identification:
    """The final identification but for that its model leaves a gap, and for what to run: that is said and done."""
    final = explanation.final
    kept = (n for n in final.notices if n.code not in (Code.MODEL_MISMATCH, Code.STRUCTURED_RESIDUAL))
    said = (replace(n, texts={**n.texts, "case": "searched"}) if n.code is Code.CAUSE_SUSPECTED else n for n in kept)
    return replace(final, notices=tuple(said))


def _steps_text(e: GapExplanation) -> str:
    """The gap of each model, of the link's position too where that was recorded and something was found."""
    rows = [(s.model, f"{s.gap:.4g}", change(e.before, s.gap, 1) if i else "") for i, s in enumerate(e.steps)]
    rows.append(("noise floor", f"{e.noise_floor:.4g}", ""))
    header = ("model", f"gap, {e.unit} rms, data not fitted", "change")
    if len(e.steps) == 1:
        return text_table(header[:2], [r[:2] for r in rows], right=(1,))
    links = [s.link_gap for s in e.steps if s.link_gap is not None]
    if not links:
        return text_table(header, rows, right=(1, 2))
    known = [f"{1e3 * gap:.4g}" for gap in links] + [""]
    wide = [(*row, gap) for row, gap in zip(rows, known, strict=True)]
    return text_table((*header, f"link, {words_of(e.final)('mrad')} rms"), wide, right=(1, 2, 3))


def gap_text(explanation: GapExplanation) -> str:
    """Verdict, steps, findings, regions, what was not accepted and what could not be tested."""
    e, words = explanation, words_of(explanation.final)
    lines = [f"{e.joint}: {e.verdict.replace('_', ' ')}: {summary_text(e)}  (sensors {e.sensors})", ""]
    first = do_first(e)
    lines += [f"do this first: {first}", ""] if first else []
    lines.append(_steps_text(e))
    for finding in e.findings:
        lines += ["", finding_text(finding, words), f"  {evidence_text(finding, words)}"]
        if finding.also_considered:
            lines.append(f"  also considered: {others_text(finding)}")
        if finding.indistinguishable_from:
            names = ", ".join(finding.indistinguishable_from)
            lines.append(f"  this recording cannot tell it from {names}; what would: {finding.experiment}")
    if e.repeats is not None and e.repeats_left is not None:
        r, left = e.repeats, e.repeats_left
        lines += [
            "",
            f"the motion repeats every {r.period_s:.3g} s: model error {r.repeatable:.3g} {e.unit} before, "
            f"{left.repeatable:.3g} after; noise {left.noise:.3g}",
        ]
    if e.where:
        lines += ["", "where the gap of the base model lies:", *(f"  {region_text(r)}" for r in e.where)]
    if e.unexplained:
        lines += ["", f"unexplained: {unexplained_text(e)}"]
    refused = [r for r in e.rejected if r.promising]
    if refused:
        lines += ["", "tried and not accepted:", *(f"  {r.effect}: {rejected_text(r, words)}" for r in refused)]
    if e.not_testable:
        lines += ["", "could not have been seen in this recording:"]
        lines += [f"  {u.effect}: {u.experiment or 'another motion'} would show it" for u in e.not_testable]
    notes, warnings = told(e.notices), warnings_of(e)
    if notes or warnings:
        lines += ["", *(f"note: {text}" for text in notes), *(f"warning: {text}" for text in warnings)]
    return "\n".join(lines)
