"""`report.html` of an explained gap."""

from __future__ import annotations

from collections.abc import Mapping

from flex_ident.effects import effect_named, told_key
from flex_ident.gap.explanation import GapExplanation
from flex_ident.parameters import Parameter
from flex_ident.parameters.parameter import PRISMATIC_UNITS
from flex_ident.recording import Recording
from flex_ident.report.advice import begun, told
from flex_ident.report.curve_plot import curve_name
from flex_ident.report.figures import embedded
from flex_ident.report.gap_table import (
    change,
    closed_share,
    do_first,
    finding_text,
    others_text,
    summary_text,
    warnings_of,
)
from flex_ident.report.gap_words import evidence_text, region_text, rejected_text, unexplained_text
from flex_ident.report.page import Image, Merit, Row, Section, page_html
from flex_ident.report.table import meaning_of, parameter_row
from flex_ident.report.units import words_of


def gap_html(explanation: GapExplanation, recording: Recording, figures: Mapping[str, bytes]) -> str:
    """One page: the steps, the findings, where the gap lay, the final model, what was rejected and why."""
    e = explanation
    merits = [
        Merit("gap before", f"{e.before:.3g} {e.unit}", "rms, data not fitted"),
        Merit("gap after", f"{e.after:.3g} {e.unit}", change(e.before, e.after)),
        Merit("noise floor", f"{e.noise_floor:.3g} {e.unit}", "cannot be beaten"),
    ]
    if e.repeats is not None and e.repeats_left is not None:
        merits.append(Merit("model error, from repeats", f"{e.repeats.repeatable:.3g} {e.unit}",
                            f"{e.repeats_left.repeatable:.3g} after"))  # fmt: skip
    sections = [
        *_read_first(e),
        Section("What each step bought", images=_image(figures, "gap_steps", "gap of each model")),
        *_findings(e, figures),
        *_unexplained(e),
        _where(e, figures),
        Section("The torque before and after", images=_image(figures, "gap_torque", "torque before and after")),
        _model(e),
        _rejected(e),
        *_untestable(e),
    ]
    return page_html(
        title=f"{e.joint}: the gap explained", heading=f"{e.joint}: what the model lacks", verdict=e.verdict,
        summary=summary_text(e).capitalize() + ".", merits=merits, sections=sections,
        source=f"Recording: {recording.path} (sha256 {recording.sha256[:16]}…). Sensors {e.sensors}.",
    )  # fmt: skip


def _read_first(e: GapExplanation) -> list[Section]:
    first, said = do_first(e), (*told(e.notices), *warnings_of(e))
    sections = [Section("Do this first", (first,))] if first else []
    items = tuple(map(begun, said))
    return [*sections, Section("Notes and warnings", items=items)] if said else sections


def _image(figures: Mapping[str, bytes], name: str, alt: str) -> tuple[Image, ...]:
    return (Image(embedded(figures[name]), alt),) if name in figures else ()


def _findings(e: GapExplanation, figures: Mapping[str, bytes]) -> list[Section]:
    sections, words = [], words_of(e.final)
    for f in e.findings:
        evidence = evidence_text(f, words)
        items = [f"Equation: {effect_named(f.effect).equation}", begun(evidence)]
        if f.also_considered:
            items.append(f"Also considered: {others_text(f).replace('_', ' ')}")
        if f.indistinguishable_from:
            names = ", ".join(n.replace("_", " ") for n in f.indistinguishable_from)
            items.append(f"This recording cannot tell it from {names}; what would: {f.experiment}")
        images = _image(figures, curve_name(f.effect), "the measured law with its 95 % band")
        title = f"Found: {f.effect.replace('_', ' ')}"
        sections.append(Section(title, (finding_text(f, words),), tuple(items), images=images))
    return sections


def _unexplained(e: GapExplanation) -> list[Section]:
    return [Section("Not explained", (unexplained_text(e),))] if e.unexplained else []


def _where(e: GapExplanation, figures: Mapping[str, bytes]) -> Section:
    return Section(
        "Where the gap of the base model lies",
        items=tuple(begun(region_text(region)) for region in e.where),
        images=_image(figures, "gap_where", "gap over position, velocity, deflection and time"),
    )


def _meaning(e: GapExplanation, p: Parameter) -> str:
    prismatic = p.unit == PRISMATIC_UNITS.get(p.key)
    return meaning_of(p.key, rigid=e.final.model.rigid, prismatic=prismatic, alone=e.sensors == "motor")


def _model(e: GapExplanation) -> Section:
    rows = tuple(
        Row((*parameter_row(p)[:5], _meaning(e, p), "yes" if p.identifiable else "no"),
            not p.identifiable)
        for p in e.final.parameters if told_key(p.key) == p.key
    )  # fmt: skip
    return Section(
        "The model with what was found", ("All parameters were identified again together; model.yaml holds them.",),
        header=("", "value", "± 2σ", "%σ", "unit", "meaning", "identifiable"), rows=rows, right=(1, 2, 3),
    )  # fmt: skip


def _rejected(e: GapExplanation) -> Section:
    words = words_of(e.final)
    rows = tuple(Row((r.effect.replace("_", " "), closed_share(r.share), rejected_text(r, words))) for r in e.rejected)
    if not rows:
        return Section("Tried and not accepted", ("Nothing else was worth a trial.",))
    return Section("Tried and not accepted", header=("effect", "% of the gap", "why not"), rows=rows, right=(1,))


def _untestable(e: GapExplanation) -> list[Section]:
    if not e.not_testable:
        return []
    rows = tuple(
        Row((u.effect.replace("_", " "), f"{100 * u.orthogonal:.1f}", u.experiment or "another motion"))
        for u in e.not_testable
    )
    text = "The model's own parameters mimic these effects under this motion, so the recording cannot show them."
    return [
        Section("Not testable with this recording", (text,), header=("effect", "% distinct", "what would show it"),
                rows=rows, right=(1,))
    ]  # fmt: skip
