"""The pictures of an explained gap: the steps, where it lay before and after, the torque before and after."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flex_ident.gap.explanation import GapExplanation, Profile
from flex_ident.recording import Floats
from flex_ident.report.curve_plot import curve_name, curve_plot
from flex_ident.report.figures import (
    LINK,
    MEASURED,
    PREDICTED,
    QUIET,
    plain_log_ticks,
    png_bytes,
    styled_figure,
    thinned,
)
from flex_ident.report.units import words_of

WORDS = {
    "time": "time", "motor_position": "motor angle", "motor_velocity": "motor velocity",
    "recorded_torque": "recorded torque", "spring_deflection": "spring deflection",
    "deflection_rate": "deflection rate", "transmitted_torque": "transmitted torque", "frequency": "frequency",
}  # fmt: skip
PROFILES = 4
BANDS = 24
LOWEST_HZ = 0.2


def steps_plot(explanation: GapExplanation) -> bytes:
    """The gap of each model of the search, on data not fitted, against the noise floor; beside it that of the link's
    position, where it was recorded and something was found."""
    names = [s.model.split(" + ")[-1] if i else "base model" for i, s in enumerate(explanation.steps)]
    labels = [n.replace("_", " ") if i == 0 else f"+ {n.replace('_', ' ')}" for i, n in enumerate(names)]
    links = [1e3 * s.link_gap for s in explanation.steps if s.link_gap is not None] if len(names) > 1 else []
    with styled_figure(8.6, 0.62 * len(names) + 1.3) as figure:
        panels = figure.subplots(
            1, 2 if links else 1, sharey=True, squeeze=False, width_ratios=[2, 1] if links else [1]
        )
        axes = panels[0, 0]
        between = "gap of the torque" if links else "gap between simulated and measured torque"
        _bars(axes, [s.gap for s in explanation.steps], f"{between} on data not fitted, {explanation.unit} rms")
        axes.set_yticks(range(len(names)), labels)
        axes.invert_yaxis()
        axes.axvline(explanation.noise_floor, color=MEASURED, ls="--", lw=1.2)
        above = axes.get_xaxis_transform()
        axes.text(explanation.noise_floor, 1.0, "noise floor", transform=above, color=MEASURED, ha="center",
                  va="bottom", fontsize=8.5)  # fmt: skip
        if links:
            _bars(panels[0, 1], links, f"of the link's position, {words_of(explanation.final)('mrad')} rms", room=1.35)
        return png_bytes(figure)


def _bars(axes: Any, gaps: list[float], label: str, *, room: float = 1.15) -> None:
    """One bar a model, the base first, each with its number."""
    axes.barh(range(len(gaps)), gaps, color=[PREDICTED] + [LINK] * (len(gaps) - 1), height=0.6)
    for i, gap in enumerate(gaps):
        axes.text(gap, i, f" {gap:.3g}", va="center", fontsize=9)
    axes.set_xlim(0, room * max(gaps))
    axes.set_xlabel(label)
    axes.grid(axis="y", visible=False)


def torque_gap_plot(explanation: GapExplanation) -> bytes:
    """The residual of base and final model over time, and a close-up of the torque where the base errs most."""
    c = explanation.curves
    assert c is not None
    usable = c.usable > 0.5
    first = np.where(usable, c.measured - c.base, np.nan)
    last = np.where(usable, c.measured - c.final, np.nan)
    with styled_figure(8.6, 4.8) as figure:
        whole, close = figure.subplots(2, 1)
        whole.plot(*thinned(c.time, first), color=PREDICTED, lw=0.8, label="base model")
        if _found(explanation):
            whole.plot(*thinned(c.time, last), color=LINK, lw=0.8, label="with what was found")
        whole.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
        whole.set_title("Measured minus simulated torque (blank: not compared)")
        whole.set_ylabel(explanation.unit)
        start = _worst_second(c.time, np.nan_to_num(first))
        part = (c.time >= start) & (c.time <= start + 2.0)
        close.plot(c.time[part], c.measured[part], color=MEASURED, lw=1.6, label="measured")
        close.plot(c.time[part], c.base[part], color=PREDICTED, lw=1.0, ls="--", label="base model")
        if _found(explanation):
            close.plot(c.time[part], c.final[part], color=LINK, lw=1.0, label="with what was found")
        close.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3)
        close.set_ylabel(f"torque, {explanation.unit}")
        close.set_xlabel("time, s (close-up where the base model errs most)")
        return png_bytes(figure)


def _worst_second(time: Floats, residual: Floats) -> float:
    rate = 1.0 / float(np.median(np.diff(time)))
    size = max(1, round(rate))
    energy = np.convolve(residual**2, np.ones(size), mode="same")
    return max(0.0, float(time[int(np.argmax(energy))]) - 1.0)


def regions_plot(explanation: GapExplanation) -> bytes:
    """The gap over the variables in which it concentrates most, before and after; its regions are shaded."""
    names = _telling(explanation)
    columns = 2
    rows = -(-len(names) // columns)
    with styled_figure(8.6, 2.3 * rows + 0.7) as figure:
        axes = np.atleast_1d(figure.subplots(rows, columns)).ravel()
        for a, name in zip(axes, names, strict=False):
            if name == "frequency":
                _spectra(a, explanation)
            else:
                before, after = explanation.profiles[name]
                a.plot(before.centre, before.rms, "o-", ms=3, color=PREDICTED)
                if _found(explanation):
                    a.plot(after.centre, after.rms, "o-", ms=3, color=LINK)
                a.axhline(explanation.noise_floor, color=QUIET, ls="--", lw=1)
                a.set_xlabel(f"{WORDS[name]}, {before.unit}")
                a.set_ylabel(f"gap, {explanation.unit} rms")
                a.locator_params(axis="x", nbins=6)
            for r in explanation.where:
                if r.variable == name:
                    a.axvspan(r.low, r.high, color=PREDICTED, alpha=0.12, lw=0)
                    a.set_title(f"{100 * r.share:.0f} % of the gap is in the shaded part", fontsize=9)
            a.set_ylim(bottom=0.0)
        for a in axes[len(names) :]:
            a.set_visible(False)
        _key(figure, found=_found(explanation), shaded=any(r.variable in names for r in explanation.where))
        return png_bytes(figure)


def _found(explanation: GapExplanation) -> bool:
    """Whether the final model is another than the base."""
    return len(explanation.steps) > 1


def _key(figure: Any, *, found: bool, shaded: bool) -> None:
    """One legend for all panels."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Line2D([], [], color=PREDICTED, marker="o", ms=3, label="base model"),
        Line2D([], [], color=QUIET, ls="--", lw=1, label="noise floor"),
    ]
    if found:
        handles.insert(1, Line2D([], [], color=LINK, marker="o", ms=3, label="with what was found"))
    if shaded:
        handles.append(Patch(color=PREDICTED, alpha=0.12, lw=0, label="where the base model's gap concentrates"))
    title = "Where the gap lies"
    figure.legend(
        handles=handles, loc="outside upper left", ncols=4, title=title, alignment="left", title_fontsize=10.5
    )


def _spectra(axes: Any, explanation: GapExplanation) -> None:
    """The gap's spectral density before and after over frequency, and that of white noise of the floor's rms."""
    c = explanation.curves
    assert c is not None
    usable = c.usable > 0.5
    rate = 1.0 / float(np.median(np.diff(c.time)))
    residuals = ((c.measured - c.base, PREDICTED), (c.measured - c.final, LINK))
    for values, colour in residuals[: 1 + _found(explanation)]:
        frequency, density = _density(values, usable, rate)
        axes.semilogx(frequency, density, "o-", ms=3, color=colour)
    axes.axhline(explanation.noise_floor / np.sqrt(0.5 * rate), color=QUIET, ls="--", lw=1)
    axes.set_xlim(0.5 * LOWEST_HZ, 0.5 * rate)
    plain_log_ticks(axes.xaxis)
    axes.set_xlabel(f"{WORDS['frequency']}, Hz")
    axes.set_ylabel(f"gap, {explanation.unit}/√Hz")


def _density(residual: Floats, usable: NDArray[np.bool_], rate_hz: float) -> tuple[Floats, Floats]:
    """Centres, Hz, of logarithmic bands and the root of the residual's mean power density in each.

    The first band takes all that is slower than LOWEST_HZ.
    """
    window = np.hanning(residual.size) * usable
    power = np.abs(np.fft.rfft(np.where(usable, residual, 0.0) * window)) ** 2
    power *= 2.0 / (rate_hz * float(np.sum(window**2)))
    frequency = np.fft.rfftfreq(residual.size, 1.0 / rate_hz)
    edges = np.concatenate(([0.5 * LOWEST_HZ], np.geomspace(LOWEST_HZ, 0.5 * rate_hz, BANDS)))
    index = np.clip(np.digitize(frequency, edges) - 1, 0, BANDS - 1)
    count = np.bincount(index, minlength=BANDS)
    total = np.bincount(index, power, BANDS)
    good = count > 0
    return np.sqrt(edges[:-1] * edges[1:])[good], np.sqrt(total[good] / count[good])


def _telling(explanation: GapExplanation) -> list[str]:
    """Variables over which the gap varies most; the regions' own first."""
    known = {*explanation.profiles, *(["frequency"] if explanation.curves is not None else [])}
    named = [r.variable for r in explanation.where if r.variable in known]
    rest = sorted(
        (n for n in explanation.profiles if n not in named), key=lambda n: -_contrast(explanation.profiles[n][0])
    )
    return [*dict.fromkeys(named), *rest][:PROFILES]


def _contrast(profile: Profile) -> float:
    return float(np.std(profile.rms) / max(float(np.mean(profile.rms)), 1e-12)) if profile.rms.size else 0.0


def gap_figures(explanation: GapExplanation) -> dict[str, bytes]:
    """Every picture of an explanation as PNG, by file name."""
    figures = {"gap_steps": steps_plot(explanation), "gap_where": regions_plot(explanation)}
    if explanation.curves is not None:
        figures["gap_torque"] = torque_gap_plot(explanation)
    for finding in explanation.findings:
        if finding.curve is not None:
            figures[curve_name(finding.effect)] = curve_plot(finding.curve, explanation.unit)
    return figures
