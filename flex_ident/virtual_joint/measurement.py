"""The measurement chain: encoders, the drive's torque reading, a clock that jitters, messages that get lost."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import ConfigurationError
from flex_ident.recording import Floats, Signal


@dataclass(frozen=True)
class MeasurementChain:
    """What stands between the joint and its recording.

    Encoder steps in rad (0: none); `torque_noise` and `torque_disturbance` relative to the rms of the torque (the
    first is read, the second acts); `jitter` as standard deviation of the sampling instants in periods; `lost` the
    share of messages that never arrive.
    """

    motor_step: float = 2.0 * math.pi / 2**20
    link_step: float = 2.0 * math.pi / 2**20
    torque_noise: float = 0.01
    torque_disturbance: float = 0.0
    jitter: float = 0.0
    lost: float = 0.0

    def __post_init__(self) -> None:
        for name in ("motor_step", "link_step", "torque_noise", "torque_disturbance", "jitter", "lost"):
            if not getattr(self, name) >= 0.0:
                raise ConfigurationError(f"{name} is {getattr(self, name)}: it must not be negative.")
        if self.lost >= 1.0:
            raise ConfigurationError(f"lost is {self.lost}: it must be below 1.")

    @classmethod
    def with_bits(cls, motor_bits: int = 20, link_bits: int = 20, **others: float) -> MeasurementChain:
        """A chain of encoders with so many bits a turn."""
        return cls(2.0 * math.pi / 2**motor_bits, 2.0 * math.pi / 2**link_bits, **others)


PERFECT = MeasurementChain(0.0, 0.0, 0.0)


def quantised(values: Floats, step: float, phase: float) -> Floats:
    """What an encoder of `step` rad, its grid shifted by the share `phase`, reads of `values` (n,)."""
    if step == 0.0:
        return values
    read: Floats = (np.floor(values / step + phase) + 0.5 - phase) * step
    return read


@dataclass(frozen=True)
class TrueMotion:
    """What the joint did, (n,) each, on a uniform clock; `torque` is the mean over the sample around each instant."""

    sample_rate_hz: float
    motor_position: Floats
    link_position: Floats
    motor_velocity: Floats
    torque: Floats
    reference: Floats


def measured_signals(
    motion: TrueMotion, chain: MeasurementChain, rng: np.random.Generator, *, torque_delay: float = 0.0,
    link_skew: float = 0.0, link: bool = True,
) -> list[Signal]:  # fmt: skip
    """The signals of one recording; all of a message share its instant. Delay and skew, s, shift torque and link."""
    rate = motion.sample_rate_hz
    n = motion.motor_position.size
    uniform = np.arange(n) / rate
    instants = uniform + rng.normal(0.0, 1.0, n) * chain.jitter / rate if chain.jitter else uniform
    instants = np.maximum.accumulate(np.maximum(instants, 0.0) + np.arange(n) * 1e-9)
    kept = rng.random(n) >= chain.lost
    kept[0] = True

    def at(values: Floats, shift: float = 0.0) -> Floats:
        if chain.jitter == 0.0 and shift == 0.0:
            return values
        return _cubic(values, (instants - shift) * rate)

    motor = quantised(at(motion.motor_position), chain.motor_step, rng.random())
    torque = at(motion.torque, torque_delay)
    noise = chain.torque_noise * float(np.std(motion.torque))
    torque = torque + rng.normal(0.0, 1.0, n) * noise
    channels = [("motor_position", "position", motor), ("motor_torque", "effort", torque)]
    if link:
        position = quantised(at(motion.link_position, link_skew), chain.link_step, rng.random())
        channels.append(("link_position", "link_position", position))
    channels.append(("reference", "reference", motion.reference))
    return [
        Signal(role, f"virtual:{name}", "header", instants[kept], values[kept])  # type: ignore[arg-type]
        for role, name, values in channels
    ]


def _cubic(values: Floats, where: Floats) -> Floats:
    """`values` (n,) at fractional indices, by cubic interpolation through four neighbours."""
    n = values.size
    k = np.clip(np.floor(where).astype(np.int64), 1, n - 3)
    x = np.clip(where, 0.0, n - 1.0) - k
    a, b, c, d = values[k - 1], values[k], values[k + 1], values[k + 2]
    result: Floats = b + 0.5 * x * (c - a + x * (2 * a - 5 * b + 4 * c - d + x * (3 * (b - c) + d - a)))
    return result
