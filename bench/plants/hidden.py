"""Hidden effects, one at a time, in three sizes from barely visible to strong."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plants.laws import Joint

EFFECTS = (
    "stribeck_friction", "torque_offset", "viscous_asymmetry", "viscous_nonlinearity", "load_dependent_friction",
    "friction_drift", "nonlinear_stiffness", "backlash", "hysteresis", "joint_damping", "torque_ripple",
    "torque_ripple_two", "kinematic_error", "time_delay", "encoder_skew", "saturation", "second_mode", "mount", "lugre",
    "position_friction", "mujoco_frictionloss",
)  # fmt: skip
"""Named as the catalogue names them where it has them."""
WEAKEST, STRONGEST = 0, 2


@dataclass(frozen=True)
class Scales:
    """Root mean squares of the clean motion: torque, N m, motor speed, rad/s, deflection and travel, rad."""

    torque: float
    speed: float
    deflection: float
    travel: float
    largest_torque: float
    duration_s: float


def with_effect(joint: Joint, effect: str, size: int, scales: Scales, rng: np.random.Generator) -> Joint:
    """The joint with one effect in it; `time_delay`, `encoder_skew` and MuJoCo's friction are not in the joint."""

    def of(small: float, middle: float, large: float) -> float:
        return (small, middle, large)[size] * float(rng.uniform(0.8, 1.25))

    sign = float(rng.choice((-1.0, 1.0)))
    cycles = float(np.exp(rng.uniform(math.log(40.0), math.log(300.0))))
    phases = rng.uniform(0.0, 2.0 * math.pi, 2)
    fraction = float(rng.uniform())
    match effect:
        case "stribeck_friction":
            return joint._replace(stribeck=of(0.25, 0.7, 2.0) * joint.FSm, stribeck_speed=0.1 * scales.speed)
        case "torque_offset":
            return joint._replace(offset=sign * of(0.01, 0.04, 0.15) * scales.torque)
        case "viscous_asymmetry":
            return joint._replace(asymmetry=sign * of(0.1, 0.3, 0.7) * joint.FVm)
        case "viscous_nonlinearity":
            return joint._replace(quadratic=of(0.15, 0.4, 1.0) * joint.FVm / scales.speed)
        case "load_dependent_friction":
            return joint._replace(load=of(0.01, 0.03, 0.08))
        case "friction_drift":
            growth = of(0.12, 0.3, 0.8)
            return joint._replace(drift=(growth if sign > 0 else -min(0.6, growth)) / scales.duration_s)
        case "nonlinear_stiffness":
            return joint._replace(cubic=of(0.01, 0.05, 0.25) * joint.K / scales.deflection**2)
        case "backlash":
            return joint._replace(gap=of(0.05, 0.2, 0.8) * scales.deflection)
        case "hysteresis":
            return joint._replace(
                dahl_torque=of(0.02, 0.06, 0.2) * joint.K * scales.deflection, dahl_deflection=0.3 * scales.deflection
            )
        case "joint_damping":
            return joint._replace(damping=2.0 * of(0.003, 0.015, 0.06) * math.sqrt(joint.K * joint.JL))
        case "torque_ripple" | "torque_ripple_two":
            first = of(0.01, 0.03, 0.1) * scales.torque
            one = joint._replace(ripple=first, ripple_cycles=cycles, ripple_phase=float(phases[0]))
            if effect == "torque_ripple":
                return one
            return one._replace(
                ripple_2=0.8 * first, ripple_2_cycles=(1.4 + fraction) * cycles, ripple_2_phase=float(phases[1])
            )
        case "kinematic_error":
            return joint._replace(
                kinematic=of(0.02, 0.07, 0.25) * scales.deflection, kinematic_cycles=cycles,
                kinematic_phase=float(phases[0]),
            )  # fmt: skip
        case "saturation":
            return joint._replace(limit=(0.9, 0.7, 0.5)[size] * scales.largest_torque)
        case "second_mode":
            return _second_mode(joint, of(0.03, 0.1, 0.3), (1.5 + fraction) * joint.locked_hz())
        case "mount":
            inertia = (joint.Jm + joint.JL) * of(60.0, 20.0, 8.0)
            omega = 2.0 * math.pi * 8.0 * 5.0**fraction
            return joint._replace(
                mount_inertia=inertia, mount_stiffness=inertia * omega**2, mount_damping=0.04 * inertia * omega
            )
        case "lugre":
            stiffness = joint.FSm / (of(0.002, 0.008, 0.03) * scales.travel)
            return joint._replace(bristle=stiffness, bristle_damping=0.1 * math.sqrt(stiffness * joint.Jm))
        case "position_friction":
            return joint._replace(
                uneven=min(0.95, of(0.15, 0.4, 0.85)), uneven_cycles=2.0 / scales.travel, uneven_phase=float(phases[0])
            )
        case "time_delay" | "encoder_skew" | "mujoco_frictionloss":
            return joint
    raise ValueError(effect)


def _second_mode(joint: Joint, share: float, frequency_hz: float) -> Joint:
    """The same link inertia in all, of which `share` hangs on a spring of its own."""
    inertia, omega = share * joint.JL, 2.0 * math.pi * frequency_hz
    return joint._replace(
        JL=joint.JL - inertia, second_inertia=inertia, second_stiffness=inertia * omega**2,
        second_damping=0.06 * inertia * omega,
    )  # fmt: skip


def samples_shifted(size: int, rng: np.random.Generator) -> float:
    """Delay or skew of one draw, in samples."""
    return (1.5, 3.0, 6.0)[size] * float(rng.uniform(0.9, 1.1))
