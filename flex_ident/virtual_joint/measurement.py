"""The measurement chain: encoders, the drive's torque reading, a clock that jitters, messages that get lost."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import ConfigurationError
from flex_ident.recording import Floats, Signal
from flex_ident.virtual_joint.motion import TrueMotion


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
CHAINS: dict[str, MeasurementChain] = {
    "perfect": PERFECT,
    "good": MeasurementChain(),
    "medium": MeasurementChain(1e-5, 2.4e-5, 0.01, 0.005),
    "paper": MeasurementChain(1e-4, 2e-4, 0.1, 0.1),
    "network": MeasurementChain(jitter=0.05, lost=0.002),
}
"""By name; `paper` is noisy enough for the uncertainties of the paper's Table 1."""


def chain_for(name: str) -> MeasurementChain:
    """The chain of that name. Raises ConfigurationError that lists them."""
    if name not in CHAINS:
        raise ConfigurationError(f"measurement chain '{name}' is not known: expected one of {', '.join(CHAINS)}.")
    return CHAINS[name]


def quantised(values: Floats, step: float, phase: float) -> Floats:
    """What an encoder of `step` rad, its grid shifted by the share `phase`, reads of `values` (n,)."""
    if step == 0.0:
        return values
    read: Floats = (np.floor(values / step + phase) + 0.5 - phase) * step
    return read


def measured_signals(
    motion: TrueMotion, chain: MeasurementChain, rng: np.random.Generator, *, torque_delay: float = 0.0,
    link_skew: float = 0.0, link: bool = True,
) -> list[Signal]:  # fmt: skip
    """The signals of one recording; all of a message share its instant. Delay and skew, s, shift torque and link."""
    uniform = motion.time
    n = uniform.size
    jitter = rng.normal(0.0, 1.0, n) * chain.jitter / motion.sample_rate_hz
    instants = np.sort(np.abs(uniform + jitter))
    kept = rng.random(n) >= chain.lost
    kept[0] = True
    read = motion.at(instants, torque_delay=torque_delay, link_skew=link_skew)
    motor = quantised(read[:, 0], chain.motor_step, rng.random())
    torque = read[:, 2] + rng.normal(0.0, 1.0, n) * chain.torque_noise * float(np.std(read[:, 2]))
    signals = [
        Signal("motor_position", "virtual:position", "header", instants[kept], motor[kept]),
        Signal("motor_torque", "virtual:effort", "header", instants[kept], torque[kept]),
    ]
    if link:
        position = quantised(read[:, 1], chain.link_step, rng.random())
        signals.append(Signal("link_position", "virtual:link_position", "header", instants[kept], position[kept]))
    signals.append(Signal("reference", "virtual:reference", "header", uniform, motion.reference))
    return signals
