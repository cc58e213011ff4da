"""A measured curve in words: which named laws lie within its band, or how far the closest is from it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from flex_ident.gap.measured import MeasuredCurve
from flex_ident.gap.thresholds import ALIKE, IN_BAND, NOTHING
from flex_ident.parameters.friction_curve import COVERED
from flex_ident.recording import Floats


@dataclass(frozen=True)
class Law:
    """A named part of a law: `columns` (n, k) of it for each of its shapes, and its `shapes`: a speed, or cycles."""

    name: str
    columns: tuple[Floats, ...]
    shapes: tuple[float, ...] = (0.0,)


@dataclass(frozen=True)
class Reading:
    """The named laws that together are closest to a curve: sizes (k,) of each by name, its shape, and how far off."""

    names: tuple[str, ...]
    sizes: tuple[float, ...]
    shapes: tuple[float, ...]
    law: Floats
    within: float
    """Share of the curve's length at which it lies within the band, or next to it."""

    @property
    def close(self) -> bool:
        """Whether it is the curve, as far as the recording tells."""
        return self.within >= IN_BAND


def read(curve: MeasuredCurve) -> str:
    """The curve in words: what it looks like, from where to where it was measured."""
    words = _FRICTION if curve.each_direction else _OTHER
    plain, further = _laws(curve)
    found: Reading | None = None
    for count in range(len(further) + 1):
        tried = [_closest(curve, plain, chosen) for chosen in combinations(further, count)]
        best = max(tried, key=lambda r: (r.within, -float(np.sum((r.law - curve.torque) ** 2))))
        if found is None or best.within > found.within + 1e-9:
            found = best
        if found.close:
            break
    assert found is not None
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


_FRICTION, _OTHER = "friction curve", "torque curve"


def _laws(curve: MeasuredCurve) -> tuple[list[Law], list[Law]]:
    """Laws that are always there, and those that may be, over the curve's places."""
    x = curve.at
    if curve.each_direction:
        fastest = float(np.max(np.abs(x)))
        speeds = tuple(map(float, np.geomspace(0.01, 0.6, 16) * fastest))
        dry = tuple(np.exp(-((x / s) ** 2)) * np.sign(x) for s in speeds)
        plain = [Law("dry", (np.sign(x),)), Law("viscous", (x,))]
        return plain, [
            Law("Stribeck", dry, speeds), Law("quadratic", (x * np.abs(x),)),
            Law("asymmetry", (np.abs(x) - _mean(curve),)),
        ]  # fmt: skip
    if curve.variable == "motor_position":
        range_ = float(np.ptp(x))
        cycles = tuple(map(float, np.linspace(0.5, 4.0, 15) * 2.0 * np.pi / range_))
        waves = tuple(np.column_stack((np.sin(c * x), np.cos(c * x))) for c in cycles)
        return [Law("constant", (np.ones_like(x),))], [Law("spring", (x - x.mean(),)), Law("ripple", waves, cycles)]
    return [Law("stiffness", (x,))], [Law("cubic", (x**3,)), Law("constant", (np.ones_like(x),))]


def _mean(curve: MeasuredCurve) -> float:
    return float(np.mean(np.abs(curve.points)))


def _closest(curve: MeasuredCurve, plain: list[Law], further: tuple[Law, ...]) -> Reading:
    """The best sizes and shapes of some laws, by least squares weighted by the band."""
    laws, best = [*plain, *further], None
    shaped = [law for law in further if len(law.columns) > 1]
    options = range(len(shaped[0].columns)) if shaped else range(1)
    weight = 1.0 / np.maximum(curve.std, 1e-12)
    for i in options:
        parts = [law.columns[i if law in shaped else 0] for law in laws]
        matrix = np.column_stack(parts)
        sizes = np.linalg.lstsq(matrix * weight[:, None], curve.torque * weight, rcond=1e-9)[0]
        law = matrix @ sizes
        cost = float(np.sum(((law - curve.torque) * weight) ** 2))
        if best is None or cost < best[0]:
            best = cost, parts, sizes, law, i
    assert best is not None
    _, parts, sizes, law, i = best
    counts = np.cumsum([1 if p.ndim == 1 else p.shape[1] for p in parts])
    norms = [float(np.linalg.norm(part)) * (1.0 if part.size > 1 else float(np.sign(part[0])))
             for part in np.split(sizes, counts[:-1])]  # fmt: skip
    near = np.abs(law - curve.torque) <= np.maximum(COVERED * curve.std, ALIKE * float(np.max(np.abs(curve.torque))))
    shapes = tuple(own.shapes[i if own in shaped else 0] for own in laws)
    return Reading(tuple(own.name for own in laws), tuple(norms), shapes, law, float(np.mean(near)))


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
