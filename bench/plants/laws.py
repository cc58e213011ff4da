"""What acts in the joint: the parameters, and the torques that depend on position, speed and time alone.

Both integrators call these; friction's set value at rest is theirs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from plants.unnamed import angle_torque, friction_torque, spring_torque

GRAVITY = 9.81


class Joint(NamedTuple):
    """Two masses, a spring, friction, gravity, and every hidden effect at zero; SI, link side of the gear.

    Gravity loads the link with 9.81 (MX cos q + MY sin q). Lengths of travel and phases are of the motor, rad.
    """

    Jm: float
    K: float
    JL: float
    FVm: float
    FSm: float
    FV: float
    FS: float
    MX: float
    MY: float
    tanh_speed: float = 0.0
    """Above zero: both Coulomb frictions are FS tanh(w / tanh_speed), rad/s; only `events` knows it."""
    offset: float = 0.0
    stribeck: float = 0.0
    stribeck_speed: float = 1.0
    asymmetry: float = 0.0
    quadratic: float = 0.0
    load: float = 0.0
    drift: float = 0.0
    """Growth of all friction per second, relative."""
    cubic: float = 0.0
    gap: float = 0.0
    dahl_torque: float = 0.0
    dahl_deflection: float = 1.0
    damping: float = 0.0
    ripple: float = 0.0
    ripple_cycles: float = 0.0
    ripple_phase: float = 0.0
    ripple_2: float = 0.0
    ripple_2_cycles: float = 0.0
    ripple_2_phase: float = 0.0
    kinematic: float = 0.0
    kinematic_cycles: float = 0.0
    kinematic_phase: float = 0.0
    limit: float = 0.0
    """Above zero: the drive delivers no more than this, N m."""
    second_inertia: float = 0.0
    second_stiffness: float = 0.0
    second_damping: float = 0.0
    mount_inertia: float = 0.0
    mount_stiffness: float = 0.0
    mount_damping: float = 0.0
    bristle: float = 0.0
    """Above zero: motor friction is LuGre's with this stiffness, N m/rad."""
    bristle_damping: float = 0.0
    uneven: float = 0.0
    """Relative change of the motor's Coulomb friction along its travel."""
    uneven_cycles: float = 0.0
    uneven_phase: float = 0.0
    cable: float = 0.0
    """A spring from the link to ground, N m/rad, and the position where it rests, rad."""
    cable_rest: float = 0.0
    double: float = 0.0
    """A load of half the period of gravity, as a balancing spring on a lever makes, N m, and its phase."""
    double_phase: float = 0.0
    friction_law: float = 0.0
    """Above zero: friction of the motor that has no name (`unnamed.friction_torque`), its size, N m, and speed."""
    friction_size: float = 0.0
    friction_speed: float = 1.0
    angle_law: float = 0.0
    """Above zero: torque over the motor's angle (`unnamed.angle_torque`), its size, N m, width and place, rad."""
    angle_size: float = 0.0
    angle_width: float = 1.0
    angle_place: float = 0.0
    spring_law: float = 0.0
    """Above zero: torque of the spring beside K (`unnamed.spring_torque`), its size, N m, and deflection, rad."""
    spring_size: float = 0.0
    spring_width: float = 1.0

    def locked_hz(self) -> float:
        """Frequency of the link with the motor held, Hz."""
        return math.sqrt(self.K / self.JL) / (2.0 * math.pi)

    def free_hz(self) -> float:
        """Frequency of the two masses against each other, Hz."""
        return math.sqrt(self.K * (1.0 / self.JL + 1.0 / self.Jm)) / (2.0 * math.pi)

    def has_memory(self) -> bool:
        """Whether it has states beside two positions and two speeds, which only `stepping` integrates."""
        return self.dahl_torque > 0 or self.second_inertia > 0 or self.mount_inertia > 0 or self.bristle > 0


@njit(cache=True)
def gravity_load(p, angle):
    """Torque that gravity takes from the link, and what balances it or pulls beside it, N m."""
    beside = p.cable * (angle - p.cable_rest) + p.double * math.sin(2.0 * angle + p.double_phase)
    return GRAVITY * (p.MX * math.cos(angle) + p.MY * math.sin(angle)) + beside


@njit(cache=True)
def gear_output(p, qm):
    """Motor position as the spring sees it, rad, and its derivative by the motor's position."""
    phase = p.kinematic_cycles * qm + p.kinematic_phase
    return qm + p.kinematic * math.sin(phase), 1.0 + p.kinematic * p.kinematic_cycles * math.cos(phase)


@njit(cache=True)
def elastic_torque(p, deflection):
    """Torque of the spring, N m: linear, cubic, behind a gap."""
    half = 0.5 * p.gap
    if deflection > half:
        d = deflection - half
    elif deflection < -half:
        d = deflection + half
    else:
        d = 0.0
    return p.K * d + p.cubic * d * d * d + spring_torque(p, d)


@njit(cache=True)
def motor_extras(p, qm, wm, t):
    """Everything smooth that brakes the motor beside FVm and the spring, N m."""
    warm = 1.0 + p.drift * t
    f = p.offset + warm * (p.asymmetry * abs(wm) + p.quadratic * wm * abs(wm))
    f += warm * friction_torque(p, wm) + angle_torque(p, qm)
    f += p.ripple * math.sin(p.ripple_cycles * qm + p.ripple_phase)
    return f + p.ripple_2 * math.sin(p.ripple_2_cycles * qm + p.ripple_2_phase)


@njit(cache=True)
def motor_dry(p, qm, wm, spring, t):
    """Largest dry friction of the motor, N m."""
    c = p.FSm * (1.0 + p.uneven * math.sin(p.uneven_cycles * qm + p.uneven_phase)) + p.load * abs(spring)
    if p.stribeck > 0.0:
        c += p.stribeck * math.exp(-((wm / p.stribeck_speed) ** 2))
    return (1.0 + p.drift * t) * c


@njit(cache=True)
def link_dry(p, t):
    """Largest dry friction of the link, N m."""
    return (1.0 + p.drift * t) * p.FS
