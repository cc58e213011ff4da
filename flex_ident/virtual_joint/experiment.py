"""What the virtual joint is commanded: a chirp whose amplitude falls as a drive's strength does, or any signal."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import ConfigurationError
from flex_ident.recording import Floats

CONSTANT_TO_HZ = 2.0
"""Frequency up to which the amplitude is constant; beyond, velocity is, and from 6 Hz acceleration."""
ACCELERATION_FROM_HZ = 6.0


@dataclass(frozen=True)
class Experiment:
    """A chirp (Hz, s, rad) from `start` rad, sampled at `sample_rate_hz`, fading in and out over `fade_s`.

    `sweep` is logarithmic or linear; `repeats` plays it that many times within `duration_s`. `shaped` False keeps the
    amplitude constant (section 4 of the paper).
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
    shaped: bool = True

    def __post_init__(self) -> None:
        if self.sweep not in ("logarithmic", "linear"):
            raise ConfigurationError(f"sweep is '{self.sweep}': expected logarithmic or linear.")
        positive = ("start_frequency_hz", "end_frequency_hz", "duration_s", "sample_rate_hz", "repeats")
        for name in positive:
            if not getattr(self, name) > 0:
                raise ConfigurationError(f"{name} is {getattr(self, name)}: it must be positive.")

    def reference(self) -> Floats:
        """Commanded motor position (n,), rad."""
        duration = self.duration_s / self.repeats
        t = np.arange(round(duration * self.sample_rate_hz)) / self.sample_rate_hz
        low, high = self.start_frequency_hz, self.end_frequency_hz
        if self.sweep == "linear":
            frequency = low + (high - low) * t / duration
            phase = 2.0 * np.pi * (low * t + 0.5 * (high - low) * t**2 / duration)
        else:
            growth = math.log(high / low) / duration
            frequency = low * np.exp(growth * t)
            phase = 2.0 * np.pi * (frequency - low) / growth
        gain = np.ones_like(t)
        if self.shaped:
            gain = np.minimum(1.0, CONSTANT_TO_HZ / frequency) * np.minimum(1.0, ACCELERATION_FROM_HZ / frequency)
        edge = np.clip(np.minimum(t, duration - t) / max(self.fade_s, 1e-9), 0.0, 1.0)
        chirp = self.amplitude * gain * (0.5 - 0.5 * np.cos(np.pi * edge)) * np.sin(phase)
        repeated: Floats = self.start + np.tile(chirp, self.repeats)
        return repeated
