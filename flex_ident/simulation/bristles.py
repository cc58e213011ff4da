"""Dry friction that bends elastically before it slides: LuGre's bristles, without their own damping.

Canudas de Wit, Olsson, Åström and Lischinsky (1995), eqs. 1 to 3: dz/dt = v - stiffness abs(v) z / g(v). Along a step
in which g and the direction stay, the torque stiffness z goes to g as an exponential of the way moved, whatever the
time that takes: exact where explicit steps in time diverge. With a constant g it is Dahl's friction.
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.compiled import compiled


def bristle_torque(direction: Floats, level: Floats, position: Floats, stiffness: float) -> Floats:
    """Dry friction (n,), N m, along a motion.

    `direction` (n,): of the motion, -1 to 1; `level` (n,): friction while it slides, N m; `position` (n,), rad;
    `stiffness` of the bristles, N m/rad.
    """
    result = np.empty_like(position)
    _bent(direction, level, position, stiffness, result)
    return result


@compiled
def _bent(direction: Floats, level: Floats, position: Floats, stiffness: float, result: Floats) -> None:
    torque = direction[0] * level[0]
    result[0] = torque
    for k in range(1, position.size):
        if level[k] > 0.0:
            goal = direction[k] * level[k]
            moved = abs(position[k] - position[k - 1])
            torque = goal + (torque - goal) * math.exp(-stiffness * moved / level[k])
        result[k] = torque
