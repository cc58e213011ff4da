"""The link of a joint whose base gives way: the base swings under the joint's reaction, positions are relative to it.

With the base at angle b: JL (q'' + b'') = tau - F - Q, and by the momentum of all that stands on it
(Jb + Jm) b'' = -Jm qm'' - (tau - F) - stiffness b - damping b', F being the link's friction. The base is heavy: it is
stepped beside the link by velocity Verlet, and the link sees its acceleration at the middle of each step.
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.compiled import compiled
from flex_ident.simulation.kernel import (
    FV,
    FV_ASYM,
    FV_QUAD,
    JL,
    RATE,
    RUNAWAY,
    SOFT,
    dry_friction,
    first_state,
    gravity,
    link_step,
    soft_friction,
    spring_torque,
)
from flex_ident.simulation.terms import Term

JM, JB = int(Term.MOTOR_INERTIA), int(Term.MOUNT_INERTIA)
KB, DB = int(Term.MOUNT_STIFFNESS), int(Term.MOUNT_DAMPING)


@compiled
def base_acceleration(
    p: Floats, tau: float, v: float, weight: float, motor: float, angle: float, rate: float, time: float
) -> float:
    """Acceleration of the base, rad/s^2, under the motor's acceleration `motor` and the link's load and friction."""
    pull = -p[JM] * motor - p[KB] * angle - p[DB] * rate
    inertia = p[JB] + p[JM]
    if v == 0.0:  # at rest the link moves with the base
        return float((pull - weight) / (inertia + p[JL]))
    viscous = (1.0 + p[RATE] * time) * (p[FV] * v + p[FV_ASYM] * abs(v) + p[FV_QUAD] * v * abs(v))
    dry = dry_friction(p, v, tau, time)
    if p[SOFT] > 0.0:
        friction = viscous + soft_friction(p, tau - viscous - weight, v, dry)
    else:
        friction = viscous + math.copysign(dry, v)
    return float((pull - tau + friction) / inertia)


@compiled
def simulated_link_on_mount(
    p: Floats, base: Floats, base_rate: Floats, step: float, torque: Floats, position: Floats, velocity: Floats,
    swing: Floats,
) -> int:  # fmt: skip
    """As `simulated_link`; fills `swing` (n,), the acceleration of the base, rad/s^2, as well."""
    n = torque.size
    q, v = first_state(p, base[0], base_rate[0])
    q2, v2, z, y = q, v, 0.0, 0.0
    bound = RUNAWAY * (10.0 + abs(q))
    angle = -gravity(p, q)[0] / p[KB] if p[KB] > 0.0 else 0.0
    rate, last = 0.0, 2 * (n - 1)
    tau = spring_torque(p, base[0], base[0] - q, base_rate[0] - v, z, y)
    motor = (base_rate[min(1, last)] - base_rate[0]) / (0.5 * step)
    before = now = base_acceleration(p, tau, v, gravity(p, q)[0], motor, angle, rate, 0.0)
    for k in range(n):
        torque[k], position[k], velocity[k], swing[k] = tau, q, v, now
        if k == n - 1:
            break
        middle = now + 0.5 * (now - before)
        q, v, q2, v2, z, y = link_step(
            p, q, v, q2, v2, z, y, base[2 * k], base[2 * k + 1], base[2 * k + 2], base_rate[2 * k],
            base_rate[2 * k + 1], base_rate[2 * k + 2], step, k * step, p[JL] * middle,
        )  # fmt: skip
        j = 2 * k + 2
        tau = spring_torque(p, base[j], base[j] - q, base_rate[j] - v, z, y)
        right = min(j + 1, last)
        motor = (base_rate[right] - base_rate[j - 1]) / (0.5 * step * (right - j + 1))
        angle += step * (rate + 0.5 * step * now)
        before = now
        ahead = rate + step * before  # the rate that damping meets, to first order
        now = base_acceleration(p, tau, v, gravity(p, q)[0], motor, angle, ahead, (k + 1) * step)
        rate += 0.5 * step * (before + now)
        if not abs(q) < bound:
            for i in range(k + 1, n):
                torque[i], position[i], velocity[i], swing[i] = np.nan, np.nan, np.nan, np.nan
            return k
    return n
