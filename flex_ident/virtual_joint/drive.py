"""The drive between a command and the motor's torque: position loop, velocity PI, effort limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel
from flex_ident.recording import Floats
from flex_ident.virtual_joint.compiled import compiled

Interface = Literal["position", "velocity", "effort"]
INTERFACES: tuple[Interface, ...] = ("position", "velocity", "effort")
BANDWIDTH_HZ = 15.0


@dataclass(frozen=True)
class Drive:
    """Gains: `position_gain` 1/s, `velocity_gain` N m s/rad, `integral_gain` N m/rad, and `effort_limit` N m."""

    position_gain: float
    velocity_gain: float
    integral_gain: float
    effort_limit: float = math.inf
    interface: Interface = "position"

    def __post_init__(self) -> None:
        if self.interface not in INTERFACES:
            raise ConfigurationError(f"interface is '{self.interface}': expected one of {', '.join(INTERFACES)}.")
        if not self.effort_limit > 0.0:
            raise ConfigurationError(f"effort limit is {self.effort_limit} N m: it must be positive.")


def drive_for(model: JointModel, *, effort_limit: float = math.inf, interface: Interface = "position") -> Drive:
    """A drive whose velocity loop closes at about 15 Hz on this joint's motor."""
    inertia = model.value("J") if model.rigid else model.value("Jm")
    omega = 2.0 * math.pi * BANDWIDTH_HZ
    gain = 1.2 * inertia * omega
    return Drive(0.25 * omega, gain, 0.05 * gain * omega, effort_limit, interface)


@compiled
def drive_torque(
    gains: Floats, kind: int, command: float, feedforward: float, position: float, velocity: float,
    integral: float, period: float,
) -> tuple[float, float]:  # fmt: skip
    """Torque, N m, for one sample and the integrator's new value. `kind`: index in INTERFACES.

    `gains` (4,): position, velocity, integral gain, effort limit. The integrator stops where the torque is limited.
    """
    if kind == 2:
        return min(max(command, -gains[3]), gains[3]), integral
    wanted = gains[0] * (command - position) + feedforward if kind == 0 else command
    error = wanted - velocity
    grown = integral + gains[2] * error * period
    torque = gains[1] * error + grown
    if torque > gains[3]:
        return gains[3], min(integral, grown)
    if torque < -gains[3]:
        return -gains[3], max(integral, grown)
    return torque, grown
