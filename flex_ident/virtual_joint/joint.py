"""The virtual joint in steps of one sample: what the node runs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel
from flex_ident.recording import Floats
from flex_ident.virtual_joint.drive import Drive, drive_cycles, drive_for
from flex_ident.virtual_joint.motion import readings
from flex_ident.virtual_joint.physics import P, plant_values
from flex_ident.virtual_joint.plant import INTEGRAL, ROW, sampled, state_at_rest

SUBSTEPS = 5
"""Steps of the plant in a cycle of the drive: ten in a sample at 1 kHz."""


@dataclass(frozen=True)
class Instruments:
    """What a driver's readings lack: encoder steps, rad (0: none), `torque_noise`, N m; `torque_disturbance` acts."""

    motor_step: float = 2.0 * math.pi / 2**20
    link_step: float = 2.0 * math.pi / 2**20
    torque_noise: float = 0.0
    torque_disturbance: float = 0.0

    def __post_init__(self) -> None:
        for name in ("motor_step", "link_step", "torque_noise", "torque_disturbance"):
            if not getattr(self, name) >= 0.0:
                raise ConfigurationError(f"{name} is {getattr(self, name)}: it must not be negative.")


@dataclass(frozen=True)
class Measurement:
    """One sample at `time`, s since the start: rad, rad/s, and N m averaged over the sample around that instant."""

    time: float
    motor_position: float
    motor_velocity: float
    motor_torque: float
    link_position: float


class VirtualJoint:
    """A joint under its drive. `step(command)` lets one sample pass and returns what was measured in its middle."""

    def __init__(
        self, model: JointModel, *, rate_hz: float = 1000.0, drive: Drive | None = None,
        instruments: Instruments | None = None, seed: int = 0, start: float = 0.0,
    ) -> None:  # fmt: skip
        if not rate_hz > 0.0:
            raise ConfigurationError(f"rate is {rate_hz} Hz: it must be positive.")
        self.model = model
        self.drive = drive or drive_for(model)
        self.instruments = instruments or Instruments()
        self.period = 1.0 / rate_hz
        self._cycles = drive_cycles(rate_hz)
        self._cycle = self.period / self._cycles
        self._p, self._gains = plant_values(model), self.drive.gains
        self._state = state_at_rest(self._p, start, start)
        holding = float(self._state[INTEGRAL])
        self._command = {"position": start, "velocity": 0.0, "effort": holding}[self.drive.interface]
        self._delay = float(self._p[P.TORQUE_DELAY]) / self._cycle
        self._skew = float(self._p[P.LINK_SKEW]) / self._cycle
        behind, ahead = max(self._delay, self._skew, 0.0), max(-self._delay, -self._skew, 0.0)
        self._lag = math.ceil(ahead)
        self._rows = np.zeros((2 * self._cycles + self._lag + math.ceil(behind) + 2, ROW))
        self._rows[:] = (*self._state[:4], holding)
        self._where = np.array([self._rows.shape[0] - self._cycles // 2 - self._lag], dtype=np.float64)
        self._rng = np.random.default_rng(seed)
        self._phases = self._rng.random(2)
        self._samples = 0
        self._compile()

    def _compile(self) -> None:
        """Compile now rather than in the first step, whose time is counted."""
        rows = self._rows.copy()
        self._advance(self._state.copy(), rows[-self._cycles :], self._command, 0.0)
        self._read(rows)

    @property
    def command(self) -> float:
        """What is commanded now: before the first step what holds the joint, a position, no velocity, or an effort."""
        return self._command

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self._samples * self.period

    def step(self, command: float) -> Measurement:
        """The measurement in the middle of the sample over which `command` holds. Non-finite: the last one."""
        if math.isfinite(command):
            self._command = command
        noise = self.instruments
        push = noise.torque_disturbance * float(self._rng.standard_normal()) if noise.torque_disturbance else 0.0
        self._rows[: -self._cycles] = self._rows[self._cycles :]
        self._advance(self._state, self._rows[-self._cycles :], self._command, push)
        motor, link, torque = self._read(self._rows)
        instant = self.time + 0.5 * self.period - self._lag * self._cycle
        self._samples += 1
        return Measurement(
            instant,
            _quantised(motor, noise.motor_step, self._phases[0]),
            float(self._rows[int(self._where[0]), 1]),
            torque + (noise.torque_noise * float(self._rng.standard_normal()) if noise.torque_noise else 0.0),
            _quantised(link, noise.link_step, self._phases[1]),
        )

    def _advance(self, state: Floats, rows: Floats, command: float, push: float) -> None:
        sampled(self._p, self._gains, self.drive.kind, state, command, push, self._cycle, SUBSTEPS, rows)

    def _read(self, rows: Floats) -> tuple[float, float, float]:
        read = readings(rows, self._where, self._cycle, float(self._cycles), self._delay, self._skew)[0]
        return float(read[0]), float(read[1]), float(read[2])


def _quantised(value: float, step: float, phase: float) -> float:
    return float((math.floor(value / step + phase) + 0.5 - phase) * step) if step > 0.0 else value
