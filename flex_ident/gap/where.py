"""Where the gap lies: its residual over time, frequency, position, velocity, deflection and transmitted torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.gap.explanation import Profile, Region
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats

BINS = 24
SMALLEST_SHARE = 0.25
"""A region is worth a word when it holds this share of the gap."""


@dataclass(frozen=True)
class Variable:
    """A quantity (m,) on the decimated clock against which the residual is looked at."""

    name: str
    unit: str
    values: Floats


def variables(problem: FitProblem, values: Values) -> tuple[Variable, ...]:
    """All quantities that this problem knows of."""
    d = problem.decimation
    motion = problem.motion
    found = [
        Variable("time", "s", problem.time),
        Variable("motor_position", "rad", motion.position[::d]),
        Variable("motor_velocity", "rad/s", motion.velocity[::d]),
        Variable("recorded_torque", "N m", problem.torque),
    ]
    link = problem.link_response_of(values)
    if link is not None:
        deflection = motion.position - link.position
        rate = motion.velocity - link.velocity
        found += [
            Variable("spring_deflection", "rad", deflection[::d]),
            Variable("deflection_rate", "rad/s", rate[::d]),
            Variable("transmitted_torque", "N m", link.spring_torque[::d]),
        ]
    return tuple(found)


def _edges(values: Floats) -> Floats:
    low, high = np.quantile(values, (0.002, 0.998))
    if high <= low:
        high = low + 1e-12
    edges: Floats = np.linspace(low, high, BINS + 1)
    return edges


def profile(variable: Variable, residual: Floats, rows: NDArray[np.bool_]) -> Profile:
    """Mean and rms of the residual (m,) in bins of the variable; empty bins are left out."""
    x, r = variable.values[rows], residual[rows]
    edges = _edges(x)
    index = np.clip(np.digitize(x, edges) - 1, 0, BINS - 1)
    count = np.bincount(index, minlength=BINS)
    good = count >= 5
    mean = np.bincount(index, r, BINS)[good] / count[good]
    rms = np.sqrt(np.bincount(index, r * r, BINS)[good] / count[good])
    return Profile(variable.name, variable.unit, (0.5 * (edges[:-1] + edges[1:]))[good], mean, rms)


def regions(
    found: tuple[Variable, ...], residual: Floats, rows: NDArray[np.bool_], rate_hz: float, floor: float
) -> tuple[Region, ...]:
    """The regions where the gap above the noise `floor`, N m rms, concentrates most, best first, at most four."""
    best = []
    for variable in found:
        region = _densest(variable, residual[rows], variable.values[rows], floor)
        if region is not None:
            best.append(region)
    spectral = _densest_frequency(residual, rows, rate_hz, floor)
    if spectral is not None:
        best.append(spectral)
    best.sort(key=lambda region: -(region.share - region.time_share))
    return tuple(best[:4])


def _densest(variable: Variable, residual: Floats, x: Floats, floor: float) -> Region | None:
    """The range of bins that holds most of the energy above the floor for its share of the time."""
    edges = _edges(x)
    index = np.clip(np.digitize(x, edges) - 1, 0, BINS - 1)
    count = np.bincount(index, minlength=BINS).astype(float)
    energy = np.maximum(np.bincount(index, residual * residual, BINS) - count * floor**2, 0.0)
    return _region(variable.name, variable.unit, edges, energy, count)


def _densest_frequency(residual: Floats, rows: NDArray[np.bool_], rate_hz: float, floor: float) -> Region | None:
    r = np.where(rows, residual, 0.0)
    power = np.abs(np.fft.rfft(r * np.hanning(r.size))) ** 2
    frequency = np.fft.rfftfreq(r.size, 1.0 / rate_hz)
    edges = np.concatenate(([0.0], np.geomspace(0.2, 0.5 * rate_hz, BINS)))
    index = np.clip(np.digitize(frequency, edges) - 1, 0, BINS - 1)
    energy = np.bincount(index, power, BINS)
    width = np.bincount(index, minlength=BINS).astype(float)
    total = float(np.mean(residual[rows] ** 2))
    noise = energy.sum() * min(1.0, floor**2 / total) * width / width.sum() if total > 0 else 0.0
    return _region("frequency", "Hz", edges, np.maximum(energy - noise, 0.0), width)


def _region(name: str, unit: str, edges: Floats, energy: Floats, weight: Floats) -> Region | None:
    total, whole = float(energy.sum()), float(weight.sum())
    if total <= 0.0 or whole <= 0.0:
        return None
    energy_sum = np.concatenate(([0.0], np.cumsum(energy))) / total
    weight_sum = np.concatenate(([0.0], np.cumsum(weight))) / whole
    best: tuple[float, int, int] | None = None
    for i in range(BINS):
        for j in range(i + 1, BINS + 1):
            share, time = energy_sum[j] - energy_sum[i], weight_sum[j] - weight_sum[i]
            if share < SMALLEST_SHARE:
                continue
            merit = float(share - time)
            if best is None or merit > best[0]:
                best = (merit, i, j)
    if best is None or best[0] < 0.1:
        return None
    _, i, j = best
    share, time = float(energy_sum[j] - energy_sum[i]), float(weight_sum[j] - weight_sum[i])
    return Region(name, float(edges[i]), float(edges[j]), share, time, unit)
