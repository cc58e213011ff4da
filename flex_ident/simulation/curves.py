"""Laws that are tables: a cubic between points, its slopes those of parabolas through three neighbours.

Linear in the torques at the points, exact for parabolas between the first point and the last, and what a point changes
ends with its neighbours' neighbours. Beyond the ends the torque stays what it is there; a spring's goes straight on.
"""

from __future__ import annotations

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.compiled import compiled


def point_slopes(at: Floats, torque: Floats) -> Floats:
    """Slope (k,) of the curve at its points (k,)."""
    if at.size < 2:
        return np.zeros(at.size)
    width = np.diff(at)
    rise = np.diff(torque) / width
    if at.size == 2:
        return np.repeat(rise, 2)
    inner = (width[1:] * rise[:-1] + width[:-1] * rise[1:]) / (width[1:] + width[:-1])
    first = ((2.0 * width[0] + width[1]) * rise[0] - width[0] * rise[1]) / (width[0] + width[1])
    last = ((2.0 * width[-1] + width[-2]) * rise[-1] - width[-1] * rise[-2]) / (width[-1] + width[-2])
    return np.concatenate(([first], inner, [last]))


def curve(at: Floats, torque: Floats, where: Floats) -> Floats:
    """Torque (n,), N m, of the curve through points (k,) at `where` (n,); nothing of no points."""
    if at.size == 0:
        return np.zeros_like(where)
    if at.size == 1:
        return np.full_like(where, torque[0])
    slope = point_slopes(at, torque)
    inside = np.clip(where, at[0], at[-1])
    i = np.clip(np.searchsorted(at, inside, side="right") - 1, 0, at.size - 2)
    width = at[i + 1] - at[i]
    s = (inside - at[i]) / width
    far, near = s * s * (3.0 - 2.0 * s), s * (1.0 - s)
    value: Floats = torque[i] + far * (torque[i + 1] - torque[i])
    value += width * near * ((1.0 - s) * slope[i] - s * slope[i + 1])
    return value


def bend(at: Floats, torque: Floats) -> Floats:
    """How far (k,) each torque lies off the straight line between its neighbours; at the ends as next to them."""
    if at.size < 3:
        return np.zeros(at.size)
    part = (at[1:-1] - at[:-2]) / (at[2:] - at[:-2])
    inner = np.abs(torque[1:-1] - torque[:-2] - part * (torque[2:] - torque[:-2]))
    return np.concatenate((inner[:1], inner, inner[-1:]))


def one_for_each_direction(speed: Floats, torque: Floats, velocity: Floats, share: Floats) -> Floats:
    """Friction torque (n,), N m, of a curve of its own for each direction, at velocities (n,).

    `speed` (k,): increasing, negative in the other direction; `share` (n,), -1 to 1: how far friction has turned over.
    Slower than the slowest point of its direction friction is what it is there.
    """
    found = np.zeros_like(velocity)
    for side in (speed < 0.0, speed > 0.0):
        direction = -1.0 if side[0] else 1.0
        acting = np.maximum(direction * share, 0.0)
        if side.any():
            found += acting * curve(speed[side], torque[side], velocity)
    return found


@compiled
def tabulated(p: Floats, points: int, where: float) -> float:
    """Torque, N m, of one table of a vector of terms at `where`, as `curve` has it, but straight on beyond its ends:
    springs do not end. `points` is the index of its number of points, after which each one's place and torque follow.
    """
    count, first = int(p[points]), points + 1
    last = first + 2 * (count - 1)
    if count == 1:
        return float(p[first + 1])
    i = first
    while i + 2 < last and p[i + 2] <= where:
        i += 2
    width = p[i + 2] - p[i]
    rise = (p[i + 3] - p[i + 1]) / width
    left = right = rise
    if i > first:
        before = p[i] - p[i - 2]
        slope = (p[i + 1] - p[i - 1]) / before
        left = (width * slope + before * rise) / (width + before)
    if i + 2 < last:
        after = p[i + 4] - p[i + 2]
        slope = (p[i + 5] - p[i + 3]) / after
        right = (width * slope + after * rise) / (width + after)
    if i == first:
        left = 2.0 * rise - right
    if i + 2 == last:
        right = 2.0 * rise - left
    if where < p[first]:
        return float(p[first + 1] + left * (where - p[first]))
    if where > p[last]:
        return float(p[last + 1] + right * (where - p[last]))
    s = (where - p[i]) / width
    value = p[i + 1] + s * s * (3.0 - 2.0 * s) * (p[i + 3] - p[i + 1])
    return float(value + width * s * (1.0 - s) * ((1.0 - s) * left - s * right))
