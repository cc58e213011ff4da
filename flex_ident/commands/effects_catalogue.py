"""`flex_ident effects`: the catalogue in words, and docs/effects.md with a picture of each signature."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flex_ident.effects import CATALOGUE, Effect, EffectParameter
from flex_ident.gap.curves import curve_candidates
from flex_ident.gap.where import variables
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.keys import key_text
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.report.figures import MEASURED, PREDICTED, QUIET, png_bytes, styled_figure
from flex_ident.report.gap_words import VARIABLES
from flex_ident.screening.candidates import candidates
from flex_ident.simulation.terms import MOST_POINTS
from flex_ident.virtual_joint import COBOT_JOINT, PERFECT, Experiment
from flex_ident.virtual_joint.run import virtual_recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BAND_HZ = 30.0
HUMP = 3.0
"""Torque at the hump of a curve in its picture, N m."""
UNMOVED = 1e-6
"""Share of a torque under which it is as it was."""
WIDE = 3.2
"""Amplitude of a sweep over a turn, rad."""
SAME = {"link_position": "motor_position", "link_velocity": "motor_velocity"}
"""Variables of the link that differ little from the motor's."""


def catalogue_text() -> str:
    """The catalogue for a terminal: what each effect is, its equation, parameters, signature and what separates it."""
    return "\n\n".join(_effect_text(e) for e in CATALOGUE.values())


def _effect_text(effect: Effect) -> str:
    lines = [f"{effect.name}: {effect.summary}", f"  equation    {effect.equation}"]
    for p in _once(effect):
        lines.append(f"  parameter   {key_text(effect.name, p.name)} [{p.unit}] {p.meaning}")
    if _further(effect):
        lines.append(f"  again       {_further(effect)}")
    lines += textwrap.wrap(f"  signature   {effect.signature}", 110, subsequent_indent=" " * 14)
    if effect.confused_with:
        lines.append(f"  like        {', '.join(effect.confused_with)}; told apart by {effect.separated_by}")
    return "\n".join(lines)


def _once(effect: Effect) -> tuple[EffectParameter, ...]:
    """The parameters of an effect that is there once, or of the first point of one that is a table."""
    return effect.parameters[:2] if effect.curve else effect.parameters[: len(effect.parameters) // len(effect.again)]


def _further(effect: Effect) -> str:
    """Where the parameters are found of an effect that is there again; empty where it is there once at most."""
    if effect.curve:
        return f"further points have the suffixes _2 to _{MOST_POINTS}; in model.yaml all are two lists"
    if len(effect.again) == 1:
        return ""
    if len(effect.again) == 2:
        return f"a further harmonic has the suffix {effect.again[1]}"
    return f"further harmonics have the suffixes {effect.again[1]} to {effect.again[-1]}"


def write_effects_page(folder: Path) -> list[Path]:
    """docs/effects.md and one picture an effect, all made by code; the paths written."""
    pictures = folder / "effects"
    pictures.mkdir(parents=True, exist_ok=True)
    problem, base = _clean_problem(Experiment(duration_s=30.0, sample_rate_hz=500.0))
    wide, _ = _clean_problem(Experiment(duration_s=30.0, sample_rate_hz=500.0, amplitude=WIDE))
    paths = []
    lines = [
        "# The catalogue of effects",
        "",
        "Made by `python bench/effects_page.py`. Each picture: what the torque lacks when a cobot's joint has the "
        "effect and the model does not, the model's own parameters left as they are, over the variable that shows it "
        "best; of what acts in the transmission, the torque that it bears beyond that of a linear spring. Red is the "
        "mean of the motion forward (over deflection: while it grows), the other line that of the motion backward.",
    ]
    for effect in CATALOGUE.values():
        path = pictures / f"{effect.name}.png"
        shown = problem if _shows(effect, problem, base) else wide
        path.write_bytes(_picture(effect, shown, base))
        paths.append(path)
        lines += ["", f"## {effect.name}", "", f"{effect.summary[0].upper()}{effect.summary[1:]}.", ""]
        lines += [f"`{effect.equation}`", "", f"Signature: {effect.signature}."]
        if effect.confused_with:
            names = ", ".join(f"`{n}`" for n in effect.confused_with)
            lines += ["", f"Confused with {names}; told apart by {effect.separated_by}."]
        lines += ["", "| parameter | unit | meaning |", "| --- | --- | --- |"]
        lines += [f"| `{p.name}` | {p.unit} | {p.meaning} |" for p in _once(effect)]
        if _further(effect):
            lines += ["", f"{_further(effect)[0].upper()}{_further(effect)[1:]}."]
        lines += ["", f"![{effect.name}](effects/{effect.name}.png)"]
    page = folder / "effects.md"
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return [page, *paths]


def _shows(effect: Effect, problem: FitProblem, base: Values) -> bool:
    """Whether that motion is enough for the effect to be tried; the others need more than a turn."""
    return effect.curve is not None or any(candidates(problem, base, effects=(effect.name,)))


def _clean_problem(experiment: Experiment) -> tuple[FitProblem, Values]:
    recording = virtual_recording(COBOT_JOINT, experiment, PERFECT)
    base = Values(COBOT_JOINT.parameters).without(("MX", "MY"))
    return FitProblem(recording, sensors="motor+link", band_hz=BAND_HZ), base


def _picture(effect: Effect, problem: FitProblem, base: Values) -> bytes:
    values = base | _example(effect, problem, base)
    torque, *link = (
        after - before for after, before in zip(problem.residuals(values), problem.residuals(base), strict=True)
    )
    with styled_figure(6.4, 2.5) as figure:
        axes = figure.subplots()
        if effect.bin_by == "frequency":
            _spectrum(axes, torque, problem.rate_hz)
        elif (beside := _beside_the_spring(problem, values)) is not None:
            _cloud(axes, effect, problem, values, beside)
            axes.set_ylabel("beside a linear spring, N m")
        elif float(np.max(np.abs(torque))) < UNMOVED * float(np.std(problem.torque)):
            _cloud(axes, effect, problem, base, -1e3 * link[0])
            axes.set_ylabel("link position, mrad")
        else:
            _cloud(axes, effect, problem, base, -torque)
            axes.set_ylabel("torque, N m")
        axes.set_title(effect.name.replace("_", " "))
        return png_bytes(figure)


def _beside_the_spring(problem: FitProblem, values: Values) -> Floats | None:
    """What the transmission bears (m,), N m, beyond stiffness times deflection; None where it is a linear spring."""
    link = problem.link_response_of(values)
    if link is None:
        return None
    more = link.spring_torque - values["K"] * (problem.motion.position - link.position)
    if float(np.std(more)) < UNMOVED * float(np.std(link.spring_torque)):
        return None
    return more[:: problem.decimation]


def _cloud(axes: Axes, effect: Effect, problem: FitProblem, values: Values, shown: Floats) -> None:
    """`shown` (m,) over the effect's variable, with a mean for each direction of motion or, of hysteresis, deflection.

    Its axis reaches down or up to nothing: else a constant would look like noise.
    """
    known = {v.name: v for v in variables(problem, values)}
    rows = problem.usable
    variable = known.get(SAME.get(effect.bin_by, effect.bin_by), known["motor_velocity"])
    axes.plot(variable.values[rows], shown[rows], ".", ms=1.0, color=QUIET)
    way = known["deflection_rate" if variable.name == "spring_deflection" else "motor_velocity"].values > 0.0
    for moving, colour in ((way, PREDICTED), (~way, MEASURED)):
        axes.plot(*_binned(variable.values[rows & moving], shown[rows & moving]), color=colour)
    low, high = float(shown[rows].min()), float(shown[rows].max())
    if high - low < 0.1 * max(abs(low), abs(high)):
        axes.set_ylim(min(0.0, 1.2 * low), max(0.0, 1.2 * high))
    axes.set_xlabel(f"{VARIABLES[variable.name]}, {variable.unit}")


def _example(effect: Effect, problem: FitProblem, base: Values) -> Values:
    """The effect at a size that shows; one that is a table with a hump in it."""
    if effect.curve is None:
        tries = [c for c in candidates(problem, base, effects=(effect.name,)) if not c.side]
        return tries[len(tries) // 2].probes[0]
    *_, curve = curve_candidates(effect, problem, base)
    at, _ = effect.curve.table_in(dict(curve.probe.columns[0]))
    hump = HUMP * np.exp(-(((at - 0.4 * at[-1]) / (0.2 * np.ptp(at))) ** 2))
    return Values.of_effect(effect.name, effect.curve.parameters_of(at, hump))


def _binned(x: Floats, y: Floats, bins: int = 60) -> tuple[Floats, Floats]:
    edges = np.linspace(x.min(), x.max(), bins + 1)
    index = np.clip(np.digitize(x, edges) - 1, 0, bins - 1)
    count = np.bincount(index, minlength=bins)
    good = count > 0
    centre: Floats = (0.5 * (edges[:-1] + edges[1:]))[good]
    mean: Floats = np.bincount(index, y, bins)[good] / count[good]
    return centre, mean


def _spectrum(axes: Axes, change: Floats, rate_hz: float) -> None:
    power = np.abs(np.fft.rfft(change * np.hanning(change.size))) * 4.0 / change.size
    frequency = np.fft.rfftfreq(change.size, 1.0 / rate_hz)
    inside = (frequency > 0.2) & (frequency < BAND_HZ * 1.2)
    axes.plot(frequency[inside], power[inside], color=MEASURED)
    axes.set_xlabel("frequency, Hz")
    axes.set_ylabel("torque, N m")
