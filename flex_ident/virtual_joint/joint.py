"""The virtual joint in steps of one sample: what the node runs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.parameters import JointModel
from flex_ident.recording import Floats
from flex_ident.virtual_joint.compiled import compiled
from flex_ident.virtual_joint.drive import INTERFACES, Drive, drive_for, drive_torque
from flex_ident.virtual_joint.physics import P, plant_values
from flex_ident.virtual_joint.plant import holding_torque, state_at_rest, stepped

SUBSTEPS = 10


@dataclass(frozen=True)
class Encoders:
    """Absolute noise of what a driver publishes: encoder steps, rad, torque noise, N m."""

    motor_step: float = 2.0 * math.pi / 2**20
    link_step: float = 2.0 * math.pi / 2**20
    torque_noise: float = 0.0


@dataclass(frozen=True)
class Measurement:
    """One sample: positions rad, velocity rad/s, torque N m averaged over the sample around the encoders' instant."""

    motor_position: float
    motor_velocity: float
    motor_torque: float
    link_position: float


@compiled
def _advanced(p: Floats, state: Floats, torque: float, h: float, warm: float, substeps: int) -> None:
    for _ in range(substeps):
        stepped(p, state, torque, h, warm)


class VirtualJoint:
    """A joint under its drive. `step(command)` returns what is measured now and then lets one sample pass."""

    def __init__(
        self, model: JointModel, *, rate_hz: float = 1000.0, drive: Drive | None = None,
        encoders: Encoders | None = None, seed: int = 0, start: float = 0.0, substeps: int = SUBSTEPS,
    ) -> None:  # fmt: skip
        self.model = model
        self.period = 1.0 / rate_hz
        self.drive = drive or drive_for(model)
        self.encoders = encoders or Encoders()
        self._p = plant_values(model)
        self._state = state_at_rest(self._p, start)
        self._integral = holding_torque(self._p, start)
        self._gains = np.array(
            [self.drive.position_gain, self.drive.velocity_gain, self.drive.integral_gain, self.drive.effort_limit]
        )
        self._kind = INTERFACES.index(self.drive.interface)
        self._rng = np.random.default_rng(seed)
        self._phases = self._rng.random(2)
        self._substeps = substeps
        self._samples = 0
        self._last_torque = self._integral
        self._last_command = start if self.drive.interface == "position" else 0.0
        delay, skew = model.value("time_delay.delay"), model.value("encoder_skew.skew")
        self._torques = _Line(delay / self.period, self._integral)
        self._links = _Line(skew / self.period, float(self._state[2]))
        _advanced(
            self._p, self._state.copy(), self._integral, self.period / substeps, 1.0, 1
        )  # compile before the clock

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self._samples * self.period

    def step(self, command: float) -> Measurement:
        """The measurement at this instant, under which `command` is held until the next. Non-finite: the last one."""
        if not math.isfinite(command):
            command = self._last_command
        motor, velocity, link = (float(self._state[i]) for i in (0, 1, 2))
        rate = (command - self._last_command) / self.period
        torque, self._integral = drive_torque(
            self._gains, self._kind, command, rate, motor, velocity, self._integral, self.period
        )
        read = self._torques.after(0.5 * (torque + self._last_torque))
        self._last_torque, self._last_command = torque, command
        limit = self._p[P.DRIVE_LIMIT]
        delivered = min(max(torque, -limit), limit) if limit > 0.0 else torque
        warm = 1.0 + self._p[P.WARMING] * self.time
        _advanced(self._p, self._state, delivered, self.period / self._substeps, warm, self._substeps)
        self._samples += 1
        noise = self.encoders.torque_noise
        return Measurement(
            _read(motor, self.encoders.motor_step, self._phases[0]),
            velocity,
            read + (noise * float(self._rng.standard_normal()) if noise else 0.0),
            _read(self._links.after(link), self.encoders.link_step, self._phases[1]),
        )


def _read(value: float, step: float, phase: float) -> float:
    return float((math.floor(value / step + phase) + 0.5 - phase) * step) if step > 0.0 else value


class _Line:
    """A delay of a fractional number of samples, zero or more."""

    def __init__(self, samples: float, first: float) -> None:
        self._samples = max(0.0, samples)
        self._values = [first] * (int(self._samples) + 2)

    def after(self, value: float) -> float:
        """The value of `samples` ago."""
        self._values.append(value)
        self._values.pop(0)
        whole = int(self._samples)
        share = self._samples - whole
        return (1.0 - share) * self._values[-1 - whole] + share * self._values[-2 - whole]
