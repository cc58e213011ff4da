"""The direction of motion, as sharp in time as the encoder allows.

Dry friction makes the acceleration jump where the velocity changes sign. A low-pass rounds that kink off and moves the
zero crossing by about (jump / acceleration) / (2 pi cutoff), always to the same side: 0.2 % of the inertia for the
friction of a cobot at 30 Hz. Fast motion leaves room for a much higher cutoff than slow motion, whose velocity
would drown in the encoder's noise; so the cutoff follows the speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from flex_ident.filtering.spectral import SpectralFilter
from flex_ident.recording import Floats

NOISE_SHARE = 0.05
"""Noise of the velocity that a cutoff may let through, relative to the speed around."""
CUTOFF_RATIO = 1.6
UNSURE = (0.5 * math.pi) ** 0.5
"""Standard deviations of a velocity over which its mean sign turns over: the slope of erf(v / sqrt 2) at zero."""
SPEED_WINDOW_S = 0.5


def velocity_noise(position_noise: float, cutoff_hz: float, sample_rate_hz: float) -> float:
    """Standard deviation of the velocity, per s, that white position noise leaves below a cutoff."""
    share = math.sqrt(min(1.0, 2.0 * cutoff_hz / sample_rate_hz))
    return position_noise * 2.0 * math.pi * cutoff_hz / math.sqrt(3.0) * share


@dataclass(frozen=True)
class SharpVelocity:
    """Velocity (n,), as sharp at reversals as the encoder allows, and `half_width` (n,): what it changes by within half
    a sample, or what the encoder cannot resolve, whichever is more. In units per s."""

    velocity: Floats
    half_width: Floats

    def direction(self) -> Floats:
        """Sign of the velocity (n,), -1 to 1, averaged over the sample it stands for."""
        direction: Floats = np.clip(self.velocity / self.half_width, -1.0, 1.0)
        return direction


def sharp_velocity(position: Floats, sample_rate_hz: float, *, lowest_hz: float) -> SharpVelocity:
    """The velocity behind a recorded `position` (n,), rad, for its direction.

    `lowest_hz` is the cutoff at low speed. Raises ExcitationError on too few samples.
    """
    n, rate = position.size, sample_rate_hz
    smooth, velocity, acceleration = SpectralFilter(n, rate, lowest_hz)(position, (0, 1, 2))
    noise = float(np.std((position - smooth)[10:-10]))
    window = max(3, round(SPEED_WINDOW_S * rate))
    speed = np.sqrt(2.0 * np.maximum(ndimage.uniform_filter1d(velocity**2, window), 0.0))
    width = UNSURE * velocity_noise(noise, lowest_hz, rate) * np.ones(n)
    sharpest = velocity
    cutoff = CUTOFF_RATIO * lowest_hz
    while cutoff < 0.45 * rate:
        spread = velocity_noise(noise, cutoff, rate)
        fast = spread < NOISE_SHARE * speed
        if not fast.any():
            break
        (sharper,) = SpectralFilter(n, rate, cutoff)(position, (1,))
        sharpest = np.where(fast, sharper, sharpest)
        width = np.where(fast, UNSURE * spread, width)
        cutoff *= CUTOFF_RATIO
    width = np.maximum(width, np.maximum(0.5 * np.abs(acceleration) / rate, 1e-12))
    return SharpVelocity(sharpest, width)
