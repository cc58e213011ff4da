"""Laws that are in no catalogue: friction over the motor's speed, torque over its angle, a spring's over deflection.

Each is smooth, and nothing at no speed or deflection.
"""

from __future__ import annotations

import math

from numba import njit

FRICTION = ("", "hump", "root", "arsinh", "levelling_off", "one_way_step", "two_valleys")
ANGLE = ("", "bump", "cable", "two_bumps")
SPRING = ("", "soft_zone", "one_sided", "step")


@njit(cache=True)
def friction_torque(p, w):
    """Friction at motor speed `w`, N m, beside FVm and FSm."""
    if p.friction_law == 0.0:
        return 0.0
    x, a = abs(w) / p.friction_speed, p.friction_size
    if p.friction_law == 1.0:  # lubricant that carries at one speed
        f = a * x * x * math.exp(1.0 - x * x)
    elif p.friction_law == 2.0:
        f = a * x / (1e-4 + x * x) ** 0.3
    elif p.friction_law == 3.0:  # Eyring's shear thinning
        f = a * math.asinh(5.0 * x)
    elif p.friction_law == 4.0:
        f = a * x / (1.0 + x)
    elif p.friction_law == 5.0:  # in one direction only
        f = 0.5 * a * (math.tanh(4.0 * (x - 1.0)) + math.tanh(4.0)) if w > 0.0 else 0.0
    else:
        f = a * math.sin(2.5 * x) * x / (1.0 + x)
    return math.copysign(f, w)


@njit(cache=True)
def angle_torque(p, qm):
    """Torque that brakes the motor at angle `qm`, N m."""
    if p.angle_law == 0.0:
        return 0.0
    x, a = (qm - p.angle_place) / p.angle_width, p.angle_size
    if p.angle_law == 1.0:
        return a * math.exp(-x * x)
    if p.angle_law == 2.0:  # a bundle that is pulled tight
        return a * math.log1p(math.exp(4.0 * x)) / 4.0
    return a * (math.exp(-((x + 1.2) ** 2)) - 0.6 * math.exp(-((1.5 * x - 1.2) ** 2)))


@njit(cache=True)
def spring_torque(p, d):
    """Torque of the spring at deflection `d` beside K, N m."""
    if p.spring_law == 0.0:
        return 0.0
    x, a = d / p.spring_width, p.spring_size
    if p.spring_law == 1.0:  # softer at small torque, as harmonic drives are
        return -a * x / (1.0 + x * x)
    if p.spring_law == 2.0:
        return a * x * x if x > 0.0 else 0.0
    return 0.5 * a * (math.tanh(3.0 * (x - 1.0)) + math.tanh(3.0 * (x + 1.0)))
