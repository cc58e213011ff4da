"""What the virtual joint is commanded: a chirp whose amplitude falls as a drive's strength does, or a richer motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flex_ident.errors import ConfigurationError
from flex_ident.recording import Floats

Profile = Literal["falling", "constant_position", "rich"]
PROFILES: tuple[Profile, ...] = ("falling", "constant_position", "rich")
CONSTANT_TO_HZ = 2.0
"""Frequency up to which the amplitude is constant; beyond, velocity is, and from 6 Hz acceleration."""
ACCELERATION_FROM_HZ = 6.0
SLOW_HZ = 0.1
SLOW_AMPLITUDE, SMALL_AMPLITUDE = 5.0, 0.3
"""Of the rich motion's parts, in amplitudes of its chirp; ±0.5, ±0.1 and ±0.03 rad by default."""
RICH_SHARES = (20.0 / 60.0, 22.0 / 60.0, 18.0 / 60.0)


@dataclass(frozen=True)
class Experiment:
    """A chirp (Hz, s, rad) around `start` rad, sampled at `sample_rate_hz`, fading in and out over `fade_s`.

    `sweep` is logarithmic or linear; `repeats` plays it that many times within `duration_s`. `profile`: the amplitude
    falls with frequency, or is constant (section 4 of the paper), or `rich`: a slow sine of large amplitude, the chirp,
    and a chirp of small amplitude.
    """

    start_frequency_hz: float = 0.1
    end_frequency_hz: float = 30.0
    duration_s: float = 60.0
    amplitude: float = 0.1
    sample_rate_hz: float = 1000.0
    start: float = 0.0
    fade_s: float = 1.0
    sweep: str = "logarithmic"
    repeats: int = 1
    profile: Profile = "falling"

    def __post_init__(self) -> None:
        if self.sweep not in ("logarithmic", "linear"):
            raise ConfigurationError(f"sweep is '{self.sweep}': expected logarithmic or linear.")
        if self.profile not in PROFILES:
            raise ConfigurationError(f"profile is '{self.profile}': expected one of {', '.join(PROFILES)}.")
        positive = ("start_frequency_hz", "end_frequency_hz", "duration_s", "sample_rate_hz", "repeats")
        for name in positive:
            if not getattr(self, name) > 0:
                raise ConfigurationError(f"{name} is {getattr(self, name)}: it must be positive.")

    def reference(self) -> Floats:
        """Commanded motor position (n,), rad."""
        duration = self.duration_s / self.repeats
        if self.profile == "rich":
            slow, large, small = (share * duration for share in RICH_SHARES)
            once = np.concatenate((self._slow_sine(slow), self._chirp(large, 1.0), self._chirp(small, SMALL_AMPLITUDE)))
        else:
            once = self._chirp(duration, 1.0)
        repeated: Floats = self.start + np.tile(once, self.repeats)
        return repeated

    def _instants(self, duration: float) -> Floats:
        instants: Floats = np.arange(round(duration * self.sample_rate_hz)) / self.sample_rate_hz
        return instants

    def _fade(self, t: Floats, duration: float) -> Floats:
        edge = np.clip(np.minimum(t, duration - t) / max(self.fade_s, 1e-9), 0.0, 1.0)
        fade: Floats = 0.5 - 0.5 * np.cos(np.pi * edge)
        return fade

    def _slow_sine(self, duration: float) -> Floats:
        t = self._instants(duration)
        sine: Floats = SLOW_AMPLITUDE * self.amplitude * self._fade(t, duration) * np.sin(2.0 * np.pi * SLOW_HZ * t)
        return sine

    def _chirp(self, duration: float, share: float) -> Floats:
        t = self._instants(duration)
        low, high = self.start_frequency_hz, self.end_frequency_hz
        if self.sweep == "linear" or low == high:
            frequency = low + (high - low) * t / duration
            phase = 2.0 * np.pi * (low * t + 0.5 * (high - low) * t**2 / duration)
        else:
            growth = math.log(high / low) / duration
            frequency = low * np.exp(growth * t)
            phase = 2.0 * np.pi * (frequency - low) / growth
        gain = np.ones_like(t)
        if self.profile != "constant_position":
            gain = np.minimum(1.0, CONSTANT_TO_HZ / frequency) * np.minimum(1.0, ACCELERATION_FROM_HZ / frequency)
        chirp: Floats = share * self.amplitude * gain * self._fade(t, duration) * np.sin(phase)
        return chirp
