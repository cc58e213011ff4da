"""Laws that are tables: a cubic between points, its slopes those of parabolas through three neighbours.

Linear in the torques at the points, exact for parabolas between the first point and the last, and what a point changes
ends with its neighbours' neighbours. Beyond the ends the torque stays what it is there.
"""

from __future__ import annotations

import numpy as np

from flex_ident.recording import Floats


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
