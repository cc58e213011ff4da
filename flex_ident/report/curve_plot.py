"""The picture of a law that was measured as a curve, with its band."""

from __future__ import annotations

from typing import Any

import numpy as np

from flex_ident.gap.measured import MeasuredCurve
from flex_ident.recording import Floats
from flex_ident.report.figures import MEASURED, PREDICTED, png_bytes, styled_figure

WORDS = {
    "motor_velocity": "motor velocity", "motor_position": "motor angle", "spring_deflection": "spring deflection",
}  # fmt: skip


def curve_name(effect: str) -> str:
    """The name of the picture's file, without its ending."""
    return f"gap_{effect}"


def curve_plot(curve: MeasuredCurve, unit: str) -> bytes:
    """The law with its 95 % band over its variable, its points marked, and what it is beyond the straight law."""
    straight = bool(curve.line.any())
    with styled_figure(8.6, 5.0 if straight else 3.0) as figure:
        panels = np.atleast_1d(figure.subplots(2 if straight else 1, 1, sharex=True))
        if straight:
            _drawn(panels[0], curve, curve.line, whole=True)
            panels[0].set_title("The law, dashed the straight one of the model")
            panels[0].set_ylabel(unit)
        _drawn(panels[-1], curve, curve.line, whole=False)
        panels[-1].set_title("Beyond the straight law, with its 95 % band" if straight else "With its 95 % band")
        panels[-1].set_ylabel(unit)
        panels[-1].set_xlabel(f"{WORDS[curve.variable]}, {curve.unit}")
        return png_bytes(figure)


def _drawn(axes: Any, curve: MeasuredCurve, line: Floats, *, whole: bool) -> None:
    """One panel: the law as it is, or what it is beyond the straight `line` (n,)."""
    less = np.zeros_like(line) if whole else line
    for side in curve.sides:
        at = curve.at[side]
        points = curve.points[(curve.points >= at[0]) & (curve.points <= at[-1])]
        beyond = (curve.torque - less)[side]
        axes.fill_between(at, (curve.lower - less)[side], (curve.upper - less)[side], color=MEASURED, alpha=0.25, lw=0)
        axes.plot(at, beyond, color=MEASURED)
        axes.plot(points, np.interp(points, at, beyond), "o", ms=3.5, color=MEASURED)
        if whole:
            axes.plot(at, line[side], "--", lw=1, color=PREDICTED)
    axes.axhline(0.0, color="#6c757d", lw=0.7)
