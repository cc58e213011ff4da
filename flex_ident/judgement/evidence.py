"""What a verdict is made of: numbers alone, so that each rule can be tried without a fit."""

from __future__ import annotations

from dataclasses import dataclass

from flex_ident.parameters import Parameter


@dataclass(frozen=True)
class Cause:
    """An effect that may be missing: its `gain` (see `screening.suspects`), and the most standard deviations by which
    it would move a parameter that the data determine; `strong` where the recording speaks for it beyond chance;
    `scales_torque` where all forces follow it, and hardly a gap is left."""

    effect: str
    gain: float
    moved_stds: float
    strong: bool = True
    scales_torque: bool = False


@dataclass(frozen=True)
class OtherJoints:
    """What the motion of other `joints` explains: `share` of what is left, by energy, and the `chance` of as much."""

    joints: tuple[str, ...]
    share: float
    chance: float


@dataclass(frozen=True)
class Evidence:
    """What is known of any result: errors in percent of the torque, on the samples fitted and on those left out, and
    the sample time in s."""

    parameters: tuple[Parameter, ...]
    error_percent: float
    validation_percent: float
    measurement: tuple[Parameter, ...]
    sample_time: float


@dataclass(frozen=True)
class LinearEvidence(Evidence):
    """Of a linear regression: whether its values are `possible` for a joint, or all `opposed` to it; groups of
    parameters of which only a combination is known; how far X5 is off, in standard deviations, where it is measured
    twice; the rate, Hz, that its derivatives need."""

    possible: bool = True
    opposed: bool = False
    undetermined: tuple[tuple[str, ...], ...] = ()
    x5_stds: float | None = None
    required_rate_hz: float = 0.0


@dataclass(frozen=True)
class FitEvidence(Evidence):
    """Of a maximum-likelihood fit: first mode and band in Hz; what is left of the torque and its noise, N m rms,
    whether that is `structured` and the noise known; causes; what other joints explain; and what of the measurement
    chain is at the end of what it can be."""

    seconds: float = 0.0
    """Length of the recording, s."""
    locked_motor_hz: float = 0.0
    band_hz: float = 0.0
    gap: float = 0.0
    noise: float = 0.0
    structured: bool = False
    burst: tuple[float, float] | None = None
    """From when to when, s, most of that is left; None where it is no short stretch."""
    link: tuple[float, float] | None = None
    """What is left of the link's position and its noise, rad rms, where that is more than noise."""
    noise_known: bool = True
    causes: tuple[Cause, ...] = ()
    other_joints: OtherJoints | None = None
    strained: tuple[str, ...] = ()
    other_end: tuple[str, float, float] | None = None
    """A key, its value, and that at the end of a fit from another start that is as likely and far off."""
