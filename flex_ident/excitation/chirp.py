"""The reference as a function of time: position and velocity in closed form, and the bounds it keeps to."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import ConfigurationError

PROFILES = ("constant_position", "constant_velocity", "constant_acceleration", "rich")
SWEEPS = ("logarithmic", "linear")
RICH_PARTS = ((0.34, 1.0), (0.36, 0.25), (0.30, 0.08))
"""Profile `rich`: share of the time and amplitude of slow sine, chirp and small chirp."""
SLOW_HZ = 0.1
CORNER_HZ = 1.0
"""Frequency from which `rich` holds velocity, and four times which acceleration, constant."""


@dataclass(frozen=True)
class ChirpSettings:
    """What is asked for: Hz, s, and `amplitude` of the motor position, rad, where the sweep starts.

    `profile` says what stays constant over the sweep; `rich` is a slow sine of `amplitude`, a chirp of a quarter and
    one of a twelfth of it, so that friction, gravity, spring and backlash can be told apart. Raises
    ConfigurationError.
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
            raise ConfigurationError(f"chirp.fade_s is {self.fade_s}: expected 0 to half of the duration.")
        if not 1 <= self.repeats <= 100:
            raise ConfigurationError(f"chirp.repeats is {self.repeats}: expected 1 to 100.")

    @property
    def total_s(self) -> float:
        """Duration of all repeats, s."""
        return self.duration_s * self.repeats


@dataclass(frozen=True)
class Part:
    """A stretch of the reference, `start` to `start + duration` s: one sweep with its own amplitude and fade."""

    start: float
    duration: float
    low_hz: float
    high_hz: float
    amplitude: float
    power: float
    """The amplitude falls with the frequency to this power: 0, 1, 2 for constant position, velocity, acceleration."""
    linear: bool
    fade: float
    cornered: bool = False
    """Constant position up to CORNER_HZ, constant velocity to four times that, constant acceleration beyond."""

    def at(self, t: float) -> tuple[float, float]:
        """Position and velocity at `t` s after the part's start."""
        low, high, total = self.low_hz, self.high_hz, self.duration
        if self.linear or low == high:
            slope = (high - low) / total
            f, df = low + slope * t, slope
            phase = 2.0 * math.pi * (low * t + 0.5 * slope * t * t)
        else:
            growth = math.log(high / low) / total
            f = low * math.exp(growth * t)
            df = growth * f
            phase = 2.0 * math.pi * (f - low) / growth
        gain, dgain = self._gain(f, df)
        edge, dedge = self._edge(t)
        a = self.amplitude * gain * edge
        da = self.amplitude * (dgain * edge + gain * dedge)
        return a * math.sin(phase), da * math.sin(phase) + a * 2.0 * math.pi * f * math.cos(phase)

    def _gain(self, f: float, df: float) -> tuple[float, float]:
        if self.cornered:
            if f <= CORNER_HZ:
                return 1.0, 0.0
            if f <= 4.0 * CORNER_HZ:
                return CORNER_HZ / f, -CORNER_HZ / f**2 * df
            gain = 4.0 * CORNER_HZ**2 / f**2
            return gain, -2.0 * gain / f * df
        if self.power == 0.0:
            return 1.0, 0.0
        gain = (self.low_hz / f) ** self.power
        return gain, -self.power * gain / f * df

    def _edge(self, t: float) -> tuple[float, float]:
        if self.fade <= 0.0:
            return 1.0, 0.0
        left, right = t / self.fade, (self.duration - t) / self.fade
        x = min(left, right)
        if x >= 1.0:
            return 1.0, 0.0
        x = max(x, 0.0)
        sign = 1.0 if left < right else -1.0
        return 0.5 - 0.5 * math.cos(math.pi * x), sign * 0.5 * math.pi / self.fade * math.sin(math.pi * x)


@dataclass(frozen=True)
class Reference:
    """The whole reference around a start position; zero outside of its time."""

    parts: tuple[Part, ...]
    total_s: float

    def at(self, t: float) -> tuple[float, float]:
        """Deviation from the start position, rad, and velocity, rad/s, at time `t` s."""
        if not 0.0 <= t < self.total_s:
            return 0.0, 0.0
        for part in self.parts:
            if part.start <= t < part.start + part.duration:
                return part.at(t - part.start)
        return 0.0, 0.0

    def bounds(self) -> tuple[float, float, float, float]:
        """Lowest and highest deviation, rad, largest speed, rad/s, and acceleration, rad/s^2, finely sampled."""
        step = 1.0 / (24.0 * max(p.high_hz for p in self.parts))
        times = np.arange(0.0, self.total_s / max(1, self._repeats()), step)
        values = np.array([self.at(float(t)) for t in times])
        acceleration = np.abs(np.diff(values[:, 1])) / step
        low, high = float(values[:, 0].min()), float(values[:, 0].max())
        # A sample lies at most 1/48 of a period from the peak: less than 1 % below it.
        return 1.01 * low, 1.01 * high, 1.01 * float(np.abs(values[:, 1]).max()), 1.01 * float(acceleration.max())

    def _repeats(self) -> int:
        first = self.parts[0]
        return sum(p.low_hz == first.low_hz and p.amplitude == first.amplitude for p in self.parts)

    @property
    def highest_hz(self) -> float:
        """The highest frequency of all parts."""
        return max(p.high_hz for p in self.parts)


def chirp_reference(settings: ChirpSettings) -> Reference:
    """The reference for the settings: a function of time, so that a late tick skips and never stretches it."""
    parts = []
    for k in range(settings.repeats):
        start = k * settings.duration_s
        if settings.profile == "rich":
            parts += _rich(settings, start)
            continue
        power = float(PROFILES.index(settings.profile))
        parts.append(
            Part(start, settings.duration_s, settings.start_frequency_hz, settings.end_frequency_hz,
                 settings.amplitude, power, settings.sweep == "linear", settings.fade_s)
        )  # fmt: skip
    return Reference(tuple(parts), settings.total_s)


def _rich(settings: ChirpSettings, start: float) -> list[Part]:
    parts = []
    for i, (share, size) in enumerate(RICH_PARTS):
        duration = share * settings.duration_s
        amplitude = size * settings.amplitude
        fade = min(settings.fade_s, 0.25 * duration)
        if i == 0:
            slow = max(SLOW_HZ, 2.0 / duration)
            parts.append(Part(start, duration, slow, slow, amplitude, 0.0, True, fade))
        else:
            low = max(settings.start_frequency_hz, 2.0 / duration)
            parts.append(Part(start, duration, low, settings.end_frequency_hz, amplitude, 0.0,
                              settings.sweep == "linear", fade, cornered=True))  # fmt: skip
        start += duration
    return parts
