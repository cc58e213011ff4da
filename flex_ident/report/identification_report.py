"""`report.html` of an identification."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flex_ident.parameters import Identification, Parameter
from flex_ident.parameters.current import is_current
from flex_ident.parameters.parameter import PRISMATIC_UNITS
from flex_ident.recording import Recording
from flex_ident.report.advice import first_thing, other_things
from flex_ident.report.figures import embedded
from flex_ident.report.friction import friction_section
from flex_ident.report.page import Image, Merit, Row, Section, page_html
from flex_ident.report.table import delay_texts, meaning_of, parameter_row, rounded

VERDICTS = {
    "trusted": "The model reproduces the torque, and inertia and stiffness are well determined.",
    "doubtful": "The numbers can be used, but read the warnings first.",
    "rejected": "Do not use these numbers: the recording does not determine them, or the model does not hold.",
}
HEADLINES = ("K", "Jm", "JL", "J", "FV", "FS")


def report_html(result: Identification, recording: Recording, figures: Mapping[str, bytes]) -> str:
    """One page: verdict, what to do next, parameters, torque, frequency response, signals, sampling."""
    merits = [
        Merit(p.key, f"{rounded(p.value, p.std)} {p.unit}", f"± {rounded(2 * p.std, 2 * p.std)} (2σ)")
        for key in HEADLINES
        for p in result.parameters
        if p.key == key and p.identifiable
    ][:4]
    sections = [
        *_advice(result),
        _parameters(result),
        *_combined(result),
        _torque(result, figures),
        *_response(result, figures),
        *friction_section(result, _image(figures, "friction", "friction over speed")),
        *_sweep(result, figures),
        _recorded(result, recording, figures),
    ]
    return page_html(
        title=f"{result.joint}: identified parameters",
        heading=result.joint,
        verdict=result.verdict,
        summary=VERDICTS[result.verdict],
        merits=merits,
        sections=sections,
        source=f"Recording: {recording.path} (sha256 {recording.sha256[:16]}…). Sensors {result.sensors}, method "
        f"{result.method}. SI units, link side of the gear.",
    )


def _image(figures: Mapping[str, bytes], name: str, alt: str) -> tuple[Image, ...]:
    return (Image(embedded(figures[name]), alt),) if name in figures else ()


def _advice(result: Identification) -> list[Section]:
    if not result.notices:
        return []
    first, others = first_thing(result), other_things(result)
    if first is None:
        return [Section("Read this first: warnings and what to do", items=others)]
    sections = [Section("Do this first", (first,))]
    return [*sections, Section("Then: warnings and what to do about them", items=others)] if others else sections


def _prismatic(p: Parameter) -> bool:
    return p.unit == PRISMATIC_UNITS.get(p.key)


def _parameters(result: Identification) -> Section:
    rows = tuple(
        Row(
            (
                *parameter_row(p)[:5],
                meaning_of(p.key, rigid=result.model.rigid, prismatic=_prismatic(p), alone=result.sensors == "motor"),
                "yes" if p.identifiable else "no",
            ),
            not p.identifiable,
        )
        for p in result.parameters
    )
    texts = []
    if "locked_motor_hz" in result.derived:
        free = result.derived.get("free_resonance_hz")
        more = "" if free is None else f", free resonance {free:.4g} Hz"
        texts.append(f"Modes of the model: locked motor {result.derived['locked_motor_hz']:.4g} Hz{more}.")
    chain = delay_texts(result)
    notes: tuple[str, ...] = (
        "A torque constant that is 5 % off makes every parameter 5 % wrong and leaves no trace in the fit.",
    )
    if chain:
        notes = (f"Measurement chain, estimated and corrected for: {'; '.join(chain)}.", *notes)
    return Section(
        "Parameters",
        texts=tuple(texts),
        header=("", "value", "± 2σ", "%σ", "unit", "meaning", "identifiable"),
        rows=rows,
        right=(1, 2, 3),
        notes=notes,
    )


def _combined(result: Identification) -> list[Section]:
    if not result.combined:
        return []
    texts: tuple[str, ...] = ()
    if "x5_sigmas" in result.derived:
        fitted = next((p.value for p in result.combined if p.key == "X5"), math.nan)
        texts = (
            f"X5 is {fitted:.4g} fitted and {result.derived['x5_predicted']:.4g} from the physical parameters: "
            f"{result.derived['x5_sigmas']:.1f} standard deviations apart. Beyond 3, eq. 18 does not hold.",
        )
    rows = tuple(Row(parameter_row(p)[:5]) for p in result.combined)
    title = "What needs no torque constant" if is_current(result.notices) else "Combined parameters of eq. 19"
    return [Section(title, texts, header=("", "value", "± 2σ", "%σ", "unit"), rows=rows, right=(1, 2, 3))]


def _torque(result: Identification, figures: Mapping[str, bytes]) -> Section:
    fit = result.fit
    return Section(
        "Measured against predicted torque",
        texts=(
            f"Relative error {fit.relative_error_percent:.2f} %; on the part that the fit did not see "
            f"{fit.validation_relative_error_percent:.2f} %.",
        ),
        images=_image(figures, "torque", "measured and predicted motor torque"),
        notes=(f"{fit.samples} samples, rank {fit.rank}, condition number {fit.condition_number:.3g} (scaled).",),
    )


def _response(result: Identification, figures: Mapping[str, bytes]) -> list[Section]:
    if "frequency_response" not in figures:
        return []
    notes: tuple[str, ...] = ()
    if result.filter is not None:
        f = result.filter
        notes = (
            f"Filter: bandwidth {f.bandwidth_rad_s:.1f} rad/s, cutoff {f.cutoff_rad_s:.1f} rad/s, order {f.order} "
            f"forward and back, {f.sample_rate_hz:.5g} Hz, one sample in {f.decimation} kept.",
        )
    image = _image(figures, "frequency_response", "apparent inertia over frequency")
    return [Section("Frequency response and modes", images=image, notes=notes)]


def _sweep(result: Identification, figures: Mapping[str, bytes]) -> list[Section]:
    if "cutoff_sweep" not in figures:
        return []
    text = "A good estimate does not depend on the filter: the curves should be level within their 2σ bands."
    image = _image(figures, "cutoff_sweep", "estimates against the filter's cutoff")
    return [Section("Estimates against the filter's cutoff", texts=(text,), images=image)]


def _recorded(result: Identification, recording: Recording, figures: Mapping[str, bytes]) -> Section:
    rows = tuple(
        Row((s.role.replace("_", " "), s.source, s.clock, str(s.samples), f"{s.rate_hz:.2f}", f"{s.jitter_percent:.1f}",
             f"{s.lost_percent:.2f}", f"{1e3 * s.longest_gap_s:.1f}", f"{1e3 * s.skew_s:.3f}"))
        for s in recording.sampling
    )  # fmt: skip
    return Section(
        "The recording",
        header=("signal", "source", "clock", "samples", "Hz", "jitter %", "lost %", "gap ms", "skew ms"),
        rows=rows,
        right=(3, 4, 5, 6, 7, 8),
        images=_image(figures, "signals", "recorded signals"),
        notes=(f"All signals were brought to one clock of {recording.sample_rate_hz:.6g} Hz.",),
    )
