"""How the motor's dry friction turns over at a reversal: at once (Coulomb), with speed, with the way, or early.

No real friction is a step in velocity: it creeps, it bends elastically before it slides (Dahl), and some simulators let
it follow the acceleration. Taken for a step, each of these is put into the inertia.
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.compiled import compiled


def friction_share(
    velocity: Floats,
    half_width: Floats,
    position: Floats,
    *,
    speed: float = 0.0,
    way: float = 0.0,
    lead: float = 0.0,
    resolution: float = 0.0,
    kink: Floats | None = None,
) -> Floats:
    """Dry friction over its size (n,), -1 to 1, along a motion.

    `velocity` (n,), rad/s, and `half_width` (n,), its change within half a sample; `position` (n,), rad. `speed`,
    rad/s: friction grows with tanh(v / speed), averaged over the sample. `way`, rad: it turns over with the way moved
    (Dahl 1968: dz/dq = (1 - z sign v) / way). `lead`: samples by which it turns over early. `resolution`, rad: what the
    position may have moved between two samples without its being seen; a `way` that is much less is none at all.
    `kink` (n,), rad/s: what a low-pass took off the velocity at reversals (see `filtering.direction`).
    """
    if kink is not None:
        velocity = velocity + kink
    share: Floats = np.clip(velocity / half_width, -1.0, 1.0)
    if speed > 0.0:
        smooth = _log_cosh((velocity + half_width) / speed) - _log_cosh((velocity - half_width) / speed)
        share = np.clip(0.5 * speed / half_width * smooth, -1.0, 1.0)
    if way > 0.0:
        turned = np.empty_like(share)
        _turned_over(share, position, way, resolution, turned)
        share = turned
    if lead != 0.0:
        at = np.arange(share.size, dtype=np.float64)
        share = np.interp(at + lead, at, share)
    return share


def as_sampled(mean: Floats) -> Floats:
    """The samples (n,) of a signal below half the sample rate whose means over a sample each are `mean` (n,).

    A mean over T takes (w T)^2 / 24 off at w, rad/s; a 24th of the second difference puts that back. Dry friction that
    was left so came out 0.2 to 0.6 % too large at 500 Hz, and the inertia with it.
    """
    samples = mean.copy()
    samples[1:-1] -= np.diff(mean, 2) / 24.0
    return samples


def _log_cosh(x: Floats) -> Floats:
    size = np.abs(x)
    result: Floats = size + np.log1p(np.exp(-2.0 * size)) - math.log(2.0)
    return result


@compiled
def _turned_over(goal: Floats, position: Floats, way: float, unseen: float, result: Floats) -> None:
    """Dahl's state along `position` (n,) towards `goal` (n,), exact in the way; fills `result` (n,)."""
    z = goal[0]
    result[0] = z
    for k in range(1, goal.size):
        z = goal[k] + (z - goal[k]) * math.exp(-(abs(position[k] - position[k - 1]) + unseen) / way)
        result[k] = z
