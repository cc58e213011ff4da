"""The drive between a command and the motor's torque: position loop, velocity PI, feedforward, effort limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel
from flex_ident.recording import Floats
from flex_ident.virtual_joint.physics import GRAVITY, P, plant_values

Interface = Literal["position", "velocity", "effort"]
INTERFACES: tuple[Interface, ...] = ("position", "velocity", "effort")
"""In the order of `plant.POSITION`, `VELOCITY`, `EFFORT`."""
BANDWIDTH_HZ = 15.0
SMOOTHING_HZ = 100.0
CYCLE_RATE_HZ = 2000.0
"""A drive's loop runs at least this often, whatever the rate of commands and recording."""
AMPLE_ACCELERATION = 150.0


@dataclass(frozen=True)
class Drive:
    """Gains: `position_gain` 1/s, `velocity_gain` N m s/rad, `integral_gain` N m/rad, and `effort_limit` N m.

    A position command is smoothed at `smoothing_hz`; its rate, and its acceleration times `inertia`, are fed forward.
    """

    position_gain: float
    velocity_gain: float
    integral_gain: float
    effort_limit: float = math.inf
    interface: Interface = "position"
    inertia: float = 0.0
    smoothing_hz: float = SMOOTHING_HZ

    def __post_init__(self) -> None:
        if self.interface not in INTERFACES:
            raise ConfigurationError(f"interface is '{self.interface}': expected one of {', '.join(INTERFACES)}.")
        for name in ("effort_limit", "smoothing_hz"):
            if not getattr(self, name) > 0.0:
                raise ConfigurationError(f"{name} of the drive is {getattr(self, name)}: it must be positive.")

    @property
    def gains(self) -> Floats:
        """The numbers (6,) that `plant.drive_torque` takes."""
        smoothing = 2.0 * math.pi * self.smoothing_hz
        return np.array(
            [self.position_gain, self.velocity_gain, self.integral_gain, self.effort_limit, self.inertia, smoothing]
        )

    @property
    def kind(self) -> int:
        """What is commanded, as the plant counts it."""
        return INTERFACES.index(self.interface)


def drive_for(model: JointModel, *, effort_limit: float = math.inf, interface: Interface = "position") -> Drive:
    """A drive whose velocity loop closes at about 15 Hz on this joint's motor."""
    inertia = model.value("J") if model.rigid else model.value("Jm")
    omega = 2.0 * math.pi * BANDWIDTH_HZ
    gain = 1.2 * inertia * omega
    return Drive(0.25 * omega, gain, 0.05 * gain * omega, effort_limit, interface, inertia)


def ample_effort(model: JointModel) -> float:
    """An effort limit, N m, to two digits, under which a chirp of 0.1 rad up to 30 Hz is not limited."""
    inertia = model.value("J") + model.value("Jm") + model.value("JL")
    friction = sum(model.value(key) for key in ("FSm", "FS", "FVm", "FV"))
    plant = plant_values(model)
    weight = GRAVITY * math.hypot(plant[P.MASS_X], plant[P.MASS_Y])
    return float(f"{AMPLE_ACCELERATION * inertia + weight + 3.0 * friction:.2g}")


def drive_cycles(rate_hz: float) -> int:
    """Cycles of the drive in one sample at `rate_hz`: even, so that a sample's middle lies between two of them."""
    return 2 * max(1, math.ceil(0.5 * CYCLE_RATE_HZ / rate_hz - 1e-9))
