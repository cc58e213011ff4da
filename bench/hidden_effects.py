"""What `confusion.py` hides in a joint: every law of the catalogue and three that are none of it, with sizes.

Sizes are log-uniform from what is nearly lost in the noise to what nobody would overlook, relative to the joint's own
torque, speed and deflection along the chirp.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.effects import CATALOGUE

OUTSIDE = ("friction_jump", "load_dead_time", "bristles")
"""Friction that jumps at one angle; torque recorded late by a time that grows with the load; a second dry friction
that slides elastically first, beside one that does not."""
NONE = "none"
CLASSES = (NONE, *(name for name, effect in CATALOGUE.items() if effect.curve is None), *OUTSIDE)
"""Tables are for laws that have no name: `unnamed_laws.py` hides those."""
NEEDS_LINK = tuple(name for name, effect in CATALOGUE.items() if effect.needs_link)
SLOWEST_CYCLES, FASTEST_CYCLES = 40.0, 300.0
HIGHEST_SECOND_MODE_HZ = 26.0


@dataclass(frozen=True)
class Scales:
    """Root mean squares along the experiment: torque, N m, motor velocity, rad/s, deflection, rad; the range, rad."""

    torque: float
    velocity: float
    deflection: float
    travel: float
    largest_torque: float
    duration_s: float
    sample_time: float


def hidden_effect(
    name: str, joint: dict[str, float], scales: Scales, rng: np.random.Generator
) -> tuple[dict[str, float], dict[str, float]]:
    """The hidden terms of one draw by the catalogue's keys (or `OUTSIDE`'s own), and the joint's changed parameters."""

    def size(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    sign = float(rng.choice((-1.0, 1.0)))
    spring = joint["K"] * scales.deflection
    phase = float(rng.uniform(0.0, 2.0 * math.pi))
    cycles = size(SLOWEST_CYCLES, FASTEST_CYCLES)
    found: dict[str, float]
    match name:
        case "none" | "gravity":
            found = {}
        case "stribeck_friction":
            found = {"amplitude": size(0.5, 2.0) * joint["FSm"], "velocity": size(0.05, 0.3) * scales.velocity}
        case "torque_offset":
            found = {"offset": sign * size(0.01, 0.1) * scales.torque}
        case "viscous_asymmetry":
            found = {"coefficient": sign * size(0.1, 0.6) * joint["FVm"]}
        case "viscous_nonlinearity":
            share = size(0.1, 0.8) if sign > 0 else -size(0.08, 0.2)
            found = {"coefficient": share * joint["FVm"] / scales.velocity}
        case "load_dependent_friction":
            found = {"coefficient": size(0.01, 0.08)}
        case "friction_drift":
            found = {"rate": sign * size(0.15, 0.6) / scales.duration_s}
        case "nonlinear_stiffness":
            share = size(0.02, 0.3) if sign > 0 else -size(0.01, 0.03)
            found = {"cubic": share * joint["K"] / scales.deflection**2}
        case "backlash":
            found = {"gap": size(0.02, 0.5) * scales.deflection}
        case "hysteresis":
            found = {"torque": size(0.02, 0.2) * spring, "deflection": size(0.1, 1.0) * scales.deflection}
        case "joint_damping":
            found = {"damping": 2.0 * size(0.005, 0.05) * math.sqrt(joint["K"] * joint["JL"])}
        case "torque_ripple":
            found = {"amplitude": size(0.005, 0.05) * scales.torque, "cycles_per_turn": cycles, "phase": phase}
        case "kinematic_error":
            found = {"amplitude": size(0.01, 0.1) * scales.deflection, "cycles_per_turn": cycles, "phase": phase}
        case "time_delay":
            found = {"delay": sign * size(1.5, 6.0) * scales.sample_time}
        case "encoder_skew":
            found = {"skew": sign * size(1.5, 6.0) * scales.sample_time}
        case "effort_lag":
            found = {"time": size(1.5, 8.0) * scales.sample_time}
        case "motor_encoder_error":
            found = {"amplitude": size(0.01, 0.1) * scales.deflection, "cycles_per_turn": cycles, "phase": phase}
        case "link_encoder_error":
            turns = float(rng.choice((1.0, 2.0)))
            found = {"amplitude": size(0.02, 0.2) * scales.deflection, "cycles_per_turn": turns, "phase": phase}
        case "viscoelastic_spring":
            unit = math.sqrt(joint["JL"] / joint["K"])
            found = {"stiffness": size(0.02, 0.3) * joint["K"], "time": size(0.3, 10.0) * unit}
        case "soft_zone":
            found = {"share": size(0.1, 0.7), "deflection": size(0.1, 1.0) * scales.deflection}
        case "saturation":
            found = {"limit": (1.0 - size(0.05, 0.5)) * scales.largest_torque}
        case "iron_saturation":
            found = {"loss": size(0.02, 0.2) / scales.largest_torque**2}
        case "torque_droop":
            found = {"loss": size(0.02, 0.2) / (2.0 * scales.velocity) ** 2}
        case "presliding_friction":
            found = {"deflection": size(0.002, 0.03) * scales.travel}
        case "position_dependent_friction":
            turns = size(2.0, 12.0) / scales.travel
            found = {"amplitude": size(0.15, 0.8) * joint["FSm"], "cycles_per_turn": turns, "phase": phase}
        case "cable_torque":
            stiffness = size(0.03, 0.3) * scales.torque / scales.travel
            found = {"stiffness": stiffness, "torque": sign * size(0.01, 0.1) * scales.torque}
        case "mount_mode":
            inertia = size(8.0, 60.0) * (joint["Jm"] + joint["JL"])
            omega = 2.0 * math.pi * size(8.0, 40.0)
            found = {"inertia": inertia, "stiffness": inertia * omega**2, "damping": 0.04 * inertia * omega}
        case "second_mode":
            return _second_mode(joint, size)
        case "friction_jump":
            found = {"torque": size(0.5, 2.0) * joint["FSm"], "angle": float(rng.uniform(-0.03, 0.03))}
        case "load_dead_time":
            found = {"delay": size(1.0, 4.0) * scales.sample_time}
        case "bristles":
            found = {"torque": size(1.0, 3.0) * joint["FSm"], "deflection": size(0.003, 0.02)}
        case _:
            raise ValueError(name)
    return {f"{name}.{key}": value for key, value in found.items()}, {}


def _second_mode(joint: dict[str, float], size) -> tuple[dict[str, float], dict[str, float]]:
    locked = math.sqrt(joint["K"] / joint["JL"]) / (2.0 * math.pi)
    frequency = size(1.3 * locked, max(1.4 * locked, min(3.0 * locked, HIGHEST_SECOND_MODE_HZ)))
    omega, inertia = 2.0 * math.pi * frequency, size(0.05, 0.3) * joint["JL"]
    found = {"inertia": inertia, "stiffness": inertia * omega**2, "damping": 2.0 * size(0.01, 0.05) * inertia * omega}
    return {f"second_mode.{k}": v for k, v in found.items()}, {"JL": joint["JL"] - inertia}
