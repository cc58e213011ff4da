"""A measured curve in words: which named laws it looks like, or how far the closest is from it."""

from __future__ import annotations

import numpy as np

from flex_ident.gap.measured import MeasuredCurve
from flex_ident.gap.reading import Reading
from flex_ident.gap.thresholds import NOTHING

FRICTION, OTHER = "friction curve", "torque curve"


def curve_words(curve: MeasuredCurve, found: Reading) -> str:
    """What the curve looks like, and from where to where it was measured; forces in N m."""
    words = FRICTION if curve.each_direction else OTHER
    parts = [_part(curve, *each) for each in zip(found.names, found.sizes, found.shapes, strict=True)]
    text = ", plus ".join(p for p in parts if p) or "nothing"
    low, high = float(curve.at[0]), float(curve.at[-1])
    over = f"measured from {low:.3g} to {high:.3g} {curve.unit}"
    if found.close:
        return f"{words}, {over}: looks like {text}"
    off = np.abs(found.law - curve.torque)
    worst = int(np.argmax(off))
    return (
        f"{words}, {over}: no named law lies within its band; the closest, {text}, is up to {off[worst]:.2g} N m off "
        f"(at {curve.at[worst]:.3g} {curve.unit}); {_extremes(curve)}"
    )


def _part(curve: MeasuredCurve, name: str, size: float, shape: float) -> str:
    """One law with its numbers; empty where it is nothing."""
    largest, fastest = float(np.max(np.abs(curve.torque))), float(np.max(np.abs(curve.at)))
    match name:
        case "dry":
            return f"{size:.3g} N m of dry friction" if abs(size) > NOTHING * largest else ""
        case "viscous":
            return f"{size:.3g} N m s/rad" if abs(size) * fastest > NOTHING * largest else ""
        case "Stribeck":
            way = "Stribeck" if size > 0.0 else "a dip at low speed"
            return f"{way} with {size:.3g} N m at {shape:.2g} rad/s"
        case "quadratic":
            felt = float(np.sqrt(NOTHING * largest / max(abs(size), 1e-300)))
            fall = "" if size > 0.0 else ", which falls,"
            return (
                f"a quadratic part{fall} of {size:.3g} N m s^2/rad^2 above {felt:.2g} rad/s" if felt < fastest else ""
            )
        case "asymmetry":
            return f"viscous friction that differs by {2.0 * size:.3g} N m s/rad between the directions"
        case "ripple":
            return f"a ripple of {abs(size):.3g} N m with {shape:.3g} cycles a turn"
        case "spring":
            return f"a spring of {size:.3g} N m/rad to the ground"
        case "cubic":
            return f"a cubic spring of {size:.3g} N m/rad^3"
        case "stiffness":
            return f"{size:.3g} N m/rad beside K" if abs(size) * fastest > NOTHING * largest else ""
        case _:
            return f"a constant of {size:.3g} N m" if abs(size) > NOTHING * largest else ""


def _extremes(curve: MeasuredCurve) -> str:
    """Where the law departs most from the straight line of the base model."""
    beyond = curve.torque - curve.line
    low, high = int(np.argmin(beyond)), int(np.argmax(beyond))
    return (
        f"it departs from the straight law by {beyond[low]:.2g} N m at {curve.at[low]:.3g} {curve.unit} and "
        f"{beyond[high]:+.2g} N m at {curve.at[high]:.3g} {curve.unit}"
    )
