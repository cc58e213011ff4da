"""Friction over speed and direction: its picture, and its table in the report."""

from __future__ import annotations

import numpy as np

from flex_ident.parameters import Identification
from flex_ident.parameters.friction_curve import FrictionCurve
from flex_ident.report.figures import MEASURED, PREDICTED, png_bytes, styled_figure
from flex_ident.report.page import Image, Row, Section
from flex_ident.report.table import rounded
from flex_ident.report.units import Words, as_they_are, words_of


def friction_plot(curve: FrictionCurve, law: tuple[float, float] | None = None, words: Words = as_they_are) -> bytes:
    """The curve of each direction with its 95 % band; `law`: FV and FS of the straight lines of the model."""
    with styled_figure(8.6, 3.0) as figure:
        axes = figure.subplots()
        for side in (curve.speed < 0.0, curve.speed > 0.0):
            speed = curve.speed[side]
            if not speed.size:
                continue
            axes.fill_between(speed, curve.lower[side], curve.upper[side], color=MEASURED, alpha=0.15, lw=0)
            axes.plot(speed, curve.friction[side], "o-", ms=3, color=MEASURED)
            if law is not None:
                ends = np.array([speed[0], speed[-1]])
                axes.plot(ends, law[0] * ends + law[1] * np.sign(ends), "--", lw=1, color=PREDICTED)
        axes.axhline(0.0, color="#6c757d", lw=0.7)
        axes.set_xlabel(words("speed, rad/s"))
        axes.set_ylabel(words("friction, N m"))
        axes.set_title("Friction over speed, with its 95 % band; dashed: FV and FS of the model")
        return png_bytes(figure)


def law_of(result: Identification) -> tuple[float, float] | None:
    """FV and FS of a result that has both."""
    values = {p.key: p.value for p in result.parameters}
    return (values["FV"], values["FS"]) if {"FV", "FS"} <= values.keys() else None


def friction_section(result: Identification, images: tuple[Image, ...]) -> list[Section]:
    """The section of the report, empty where the result has no curve."""
    curve = result.friction_curve
    if curve is None:
        return []
    words = words_of(result)
    rows = tuple(
        Row((f"{v:.4g}", rounded(f, s), f"{rounded(f - 1.96 * s, s)} to {rounded(f + 1.96 * s, s)}"))
        for v, f, s in zip(curve.speed, curve.friction, curve.std, strict=True)
    )
    note = (
        "Without a law of friction: straight between the speeds shown. A constant torque is not in it: friction is "
        "taken as alike in both directions at the slowest speeds."
    )
    return [
        Section(
            "Friction over speed",
            header=(words("speed, rad/s"), words("friction, N m"), "95 %"),
            rows=rows,
            right=(0, 1, 2),
            images=images,
            notes=(note,),
        )
    ]
