"""Which named laws lie within the band of a measured curve, or come closest to it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from flex_ident.gap.measured import MeasuredCurve
from flex_ident.gap.thresholds import ALIKE, IN_BAND
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


def read(curve: MeasuredCurve) -> Reading:
    """The fewest named laws that lie within the curve's band; those that come closest where none do."""
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
    return found


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
