"""What needs no scale of the effort: ratios of parameters, where a current of unknown torque constant is recorded."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flex_ident.estimation.estimate import Estimate
from flex_ident.parameters import Parameter

RATIOS = (
    ("JL", "Jm", ""), ("K", "Jm", "1/s^2"), ("K", "JL", "1/s^2"), ("FVm", "Jm", "1/s"), ("FSm", "Jm", "rad/s^2"),
    ("FV", "JL", "1/s"), ("FS", "JL", "rad/s^2"), ("FV", "J", "1/s"), ("FS", "J", "rad/s^2"), ("MX", "J", "1/m"),
    ("MY", "J", "1/m"), ("MX", "JL", "1/m"), ("MY", "JL", "1/m"),
)  # fmt: skip
"""Numerator, denominator and unit: inertias, stiffness over inertia, decay of speed, deceleration, pull of gravity."""


def ratios(estimate: Estimate, parameters: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """The ratios of those parameters that the data determine, each with its standard deviation, to first order."""
    known = {p.key: p for p in parameters if p.identifiable}
    free, covariance = estimate.uncertainty.free, estimate.uncertainty.covariance
    found: list[Parameter] = []
    for upper, lower, unit in RATIOS:
        if not {upper, lower} <= known.keys() or not {upper, lower} <= set(free) or known[lower].value == 0.0:
            continue
        one, other = known[upper], known[lower]
        i, j = free.index(upper), free.index(lower)
        slope = 1.0 / other.value, -one.value / other.value**2
        variance = slope[0] ** 2 * one.std**2 + slope[1] ** 2 * other.std**2
        variance += 2.0 * slope[0] * slope[1] * float(covariance[i, j])
        value = one.value / other.value
        found.append(Parameter(f"{upper}/{lower}", value, math.sqrt(max(variance, 0.0)), unit))
    return tuple(found)
