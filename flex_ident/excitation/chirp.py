"""The reference as a function of time: position, velocity and acceleration in closed form, and their bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import ConfigurationError
from flex_ident.excitation.sweep import Sweep

PROFILES = ("constant_position", "constant_velocity", "constant_acceleration", "rich")
SWEEPS = ("logarithmic", "linear")
RICH_PARTS = ((0.34, 1.0), (0.36, 0.25), (0.30, 0.08))
"""Profile `rich`: share of the time and amplitude of slow sine, chirp and small chirp."""
RICH_REPEATS = 2
"""`rich` is played this often at least: what repeats is model error, the rest is noise."""
SLOW_HZ = 0.1
CORNERS_HZ = (1.0, 4.0)
"""Frequencies from which `rich` holds velocity, then acceleration constant."""
SAMPLES_PER_PERIOD = 48
BLOCK = 1 << 18


@dataclass(frozen=True)
class ChirpSettings:
    """What is asked for: Hz, s, and `amplitude` of the motor position, rad, where the sweep starts.

    `profile` says what stays constant over the sweep; `rich` is a slow sine of `amplitude`, a chirp of a quarter and
    one of a twelfth of it, all played twice at least, so that friction, gravity, spring and backlash can be told apart.
    Raises ConfigurationError.
    """

    start_frequency_hz: float = 0.05
    end_frequency_hz: float = 30.0
    duration_s: float = 60.0
    amplitude: float = 0.1
    profile: str = "constant_velocity"
    sweep: str = "logarithmic"
    fade_s: float = 1.0
    repeats: int = 1

    def __post_init__(self) -> None:
        for name in ("start_frequency_hz", "end_frequency_hz", "duration_s", "amplitude"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ConfigurationError(f"chirp.{name} is {value}: it must be positive.")
        if self.profile not in PROFILES:
            raise ConfigurationError(f"chirp.profile is '{self.profile}': expected one of {', '.join(PROFILES)}.")
        if self.sweep not in SWEEPS:
            raise ConfigurationError(f"chirp.sweep is '{self.sweep}': expected one of {', '.join(SWEEPS)}.")
        if not 0.0 <= self.fade_s <= 0.5 * self.duration_s:
            raise ConfigurationError(
                f"chirp.fade_s is {self.fade_s}: expected 0 to half of chirp.duration_s, {0.5 * self.duration_s:g}."
            )
        if not 1 <= self.repeats <= 100:
            raise ConfigurationError(f"chirp.repeats is {self.repeats}: expected 1 to 100.")

    @property
    def played(self) -> int:
        """How often the sweep is played."""
        return max(self.repeats, RICH_REPEATS) if self.profile == "rich" else self.repeats


class Bounds(NamedTuple):
    """Lowest and highest deviation from the start position, rad; largest speed, rad/s, and acceleration, rad/s^2."""

    low: float
    high: float
    speed: float
    acceleration: float


@dataclass(frozen=True)
class Reference:
    """The sweeps of one period, played `repeats` times: a function of time, so that a late tick skips.

    Around the start position, which is not part of it; zero outside of its time.
    """

    sweeps: tuple[Sweep, ...]
    repeats: int

    @cached_property
    def period_s(self) -> float:
        """Duration of one repeat, s."""
        return sum(sweep.duration for sweep in self.sweeps)

    @cached_property
    def total_s(self) -> float:
        """Duration of all repeats, s."""
        return self.period_s * self.repeats

    @property
    def highest_hz(self) -> float:
        """The highest frequency of all sweeps."""
        return max(max(sweep.low_hz, sweep.high_hz) for sweep in self.sweeps)

    def at(self, t: float) -> tuple[float, float, float]:
        """Deviation from the start position, rad, velocity, rad/s, and acceleration, rad/s^2, at time `t` s."""
        if not 0.0 <= t < self.total_s:
            return 0.0, 0.0, 0.0
        left = math.fmod(t, self.period_s)
        for sweep in self.sweeps:
            if left < sweep.duration:
                return sweep.at(left)
            left -= sweep.duration
        return 0.0, 0.0, 0.0

    @cached_property
    def bounds(self) -> Bounds:
        """The bounds over the whole run, from samples dense enough to miss less than 0.3 %, which are added."""
        low = high = speed = acceleration = 0.0
        for sweep in self.sweeps:
            for block in _dense_instants(sweep):
                position, velocity, second = sweep.motion(block)
                low, high = min(low, float(position.min())), max(high, float(position.max()))
                speed = max(speed, float(np.abs(velocity).max()))
                acceleration = max(acceleration, float(np.abs(second).max()))
        margin = 1.0 / math.cos(math.pi / SAMPLES_PER_PERIOD)
        return Bounds(margin * low, margin * high, margin * speed, margin * acceleration)


def _dense_instants(sweep: Sweep) -> list[NDArray[np.float64]]:
    """Instants, SAMPLES_PER_PERIOD in each period of the sweep and of its fades, in blocks."""
    count = math.ceil(SAMPLES_PER_PERIOD * max(sweep.periods, 1.0)) + 1
    blocks = [
        sweep.instants(np.arange(first, min(first + BLOCK, count)) / SAMPLES_PER_PERIOD)
        for first in range(0, count, BLOCK)
    ]
    fade = np.linspace(0.0, sweep.fade, 2 * SAMPLES_PER_PERIOD)
    return [*blocks, fade, sweep.duration - fade]


def chirp_reference(settings: ChirpSettings) -> Reference:
    """The reference for the settings."""
    linear = settings.sweep == "linear"
    if settings.profile == "rich":
        return Reference(_rich(settings, linear), settings.played)
    sweep = Sweep(
        settings.duration_s, settings.start_frequency_hz, settings.end_frequency_hz, settings.amplitude,
        fade=settings.fade_s, linear=linear, power=PROFILES.index(settings.profile),
    )  # fmt: skip
    return Reference((sweep,), settings.played)


def _rich(settings: ChirpSettings, linear: bool) -> tuple[Sweep, ...]:
    """A slow sine of a whole number of periods, a chirp and a small chirp, in the time of one repeat."""
    sweeps = []
    for k, (share, size) in enumerate(RICH_PARTS):
        duration, amplitude = share * settings.duration_s, size * settings.amplitude
        fade = min(settings.fade_s, 0.25 * duration)
        if k == 0:
            slow = max(round(SLOW_HZ * duration), 2) / duration
            sweeps.append(Sweep(duration, slow, slow, amplitude, fade=fade))
        else:
            sweeps.append(
                Sweep(duration, settings.start_frequency_hz, settings.end_frequency_hz, amplitude, fade=fade,
                      linear=linear, corners_hz=CORNERS_HZ)
            )  # fmt: skip
    return tuple(sweeps)
