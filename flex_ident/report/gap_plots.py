"""The pictures of an explained gap: the steps, where it lay before and after, the torque before and after."""

from __future__ import annotations

import numpy as np

from flex_ident.gap.explanation import GapExplanation, Profile
from flex_ident.recording import Floats
from flex_ident.report.figures import LINK, MEASURED, PREDICTED, QUIET, png_bytes, styled_figure, thinned

WORDS = {
    "time": "time", "motor_position": "motor angle", "motor_velocity": "motor velocity",
    "recorded_torque": "recorded torque", "spring_deflection": "spring deflection",
    "deflection_rate": "deflection rate", "transmitted_torque": "transmitted torque",
}  # fmt: skip
PROFILES = 4


def steps_plot(explanation: GapExplanation) -> bytes:
    """The gap of each model of the search, on data not fitted, against the noise floor."""
    names = [s.model.split(" + ")[-1] if i else "base model" for i, s in enumerate(explanation.steps)]
    gaps = [s.gap for s in explanation.steps]
    with styled_figure(8.6, 0.62 * len(gaps) + 1.3) as figure:
        axes = figure.subplots()
        colours = [PREDICTED] + [LINK] * (len(gaps) - 1)
        axes.barh(range(len(gaps)), gaps, color=colours, height=0.6)
        labels = [n.replace("_", " ") if i == 0 else f"+ {n.replace('_', ' ')}" for i, n in enumerate(names)]
        axes.set_yticks(range(len(gaps)), labels)
        axes.invert_yaxis()
        axes.axvline(explanation.noise_floor, color=MEASURED, ls="--", lw=1.2)
        axes.text(explanation.noise_floor, -0.62, " noise floor", color=MEASURED, va="bottom", fontsize=8.5)
        for i, gap in enumerate(gaps):
            axes.text(gap, i, f" {gap:.3g}", va="center", fontsize=9)
        axes.set_xlim(0, 1.15 * max(gaps))
        axes.set_xlabel(f"gap between simulated and measured torque on data not fitted, {explanation.unit} rms")
        axes.grid(axis="y", visible=False)
        return png_bytes(figure)


def torque_gap_plot(explanation: GapExplanation) -> bytes:
    """The residual of base and final model over time, and a close-up of the torque where the base errs most."""
    c = explanation.curves
    assert c is not None
    usable = c.usable > 0.5
    first = np.where(usable, c.measured - c.base, np.nan)
    last = np.where(usable, c.measured - c.final, np.nan)
    with styled_figure(8.6, 4.8) as figure:
        whole, close = figure.subplots(2, 1)
        whole.plot(*thinned(c.time, np.nan_to_num(first)), color=PREDICTED, lw=0.8, label="base model")
        whole.plot(*thinned(c.time, np.nan_to_num(last)), color=LINK, lw=0.8, label="with what was found")
        whole.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
        whole.set_title("Measured minus simulated torque")
        whole.set_ylabel(explanation.unit)
        start = _worst_second(c.time, np.nan_to_num(first))
        part = (c.time >= start) & (c.time <= start + 2.0)
        close.plot(c.time[part], c.measured[part], color=MEASURED, lw=1.6, label="measured")
        close.plot(c.time[part], c.base[part], color=PREDICTED, lw=1.0, ls="--", label="base model")
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
    """The gap's rms over the variables in which it concentrates most, before and after."""
    names = _telling(explanation)
    columns = 2
    rows = -(-len(names) // columns)
    with styled_figure(8.6, 2.3 * rows + 0.3) as figure:
        axes = np.atleast_1d(figure.subplots(rows, columns)).ravel()
        for a, name in zip(axes, names, strict=False):
            before, after = explanation.profiles[name]
            a.plot(before.centre, before.rms, "o-", ms=3, color=PREDICTED, label="base model")
            a.plot(after.centre, after.rms, "o-", ms=3, color=LINK, label="with what was found")
            a.axhline(explanation.noise_floor, color=QUIET, ls="--", lw=1)
            for r in explanation.where:
                if r.variable == name:
                    a.axvspan(r.low, r.high, color=PREDICTED, alpha=0.1, lw=0)
            a.set_xlabel(f"{WORDS[name]}, {before.unit}")
            a.set_ylim(bottom=0.0)
        axes[0].legend(loc="best")
        for a in axes[::columns]:
            a.set_ylabel(f"gap, {explanation.unit} rms")
        for a in axes[len(names) :]:
            a.set_visible(False)
        figure.suptitle("Where the gap lies (dashed: noise)", x=0.01, ha="left", fontsize=10.5)
        return png_bytes(figure)


def _telling(explanation: GapExplanation) -> list[str]:
    """Variables over which the gap varies most."""
    named = [r.variable for r in explanation.where if r.variable in explanation.profiles]
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
    return figures
