"""The direction of motion, as sharp in time as the encoder allows.

Dry friction makes the acceleration jump where the velocity changes sign. A low-pass rounds that kink off and moves the
zero crossing by about (jump / acceleration) / (20 cutoff), always to the same side: 0.2 % of the inertia for the
friction of a cobot at 30 Hz. Fast motion leaves room for a much higher cutoff than slow motion, whose velocity
would drown in the encoder's noise; so the cutoff follows the speed. What is still rounded off is known for a jump of a
known size, so that a model whose friction and inertia are known can put it back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from flex_ident.filtering.spectral import ORDER, SpectralFilter
from flex_ident.recording import Floats

NOISE_SHARE = 0.02
"""Noise of the velocity that a cutoff may let through, relative to the speed around.

Friction of the plants in `bench/coverage.py` does not lead. Recordings 19, 24 and 44 of seed 131 were fitted with leads
of 0.00, 0.01 and 0.03 ms; with 0.05 it was -0.31, 0.01 and -0.60 ms, with 0.008 it was 0.00, 0.00 and 3.1 ms.
"""
CUTOFF_RATIO = 1.6
UNSURE = (0.5 * math.pi) ** 0.5
"""Standard deviations of a velocity over which its mean sign turns over: the slope of erf(v / sqrt 2) at zero."""
SPEED_WINDOW_S = 0.5
REACH_PERIODS = 1.5
"""Periods of the cutoff around a reversal within which a kink is rounded off."""
KINK_ROUNDED = 1.0 / (2.0 * ORDER * math.pi * math.sin((2 * ORDER - 1) * math.pi / (2 * ORDER)))
"""Mean distance from its middle of the low-pass's impulse response, over the period of its cutoff.

That of 1 / (1 + x^2m) is (1 / pi^2) times the integral of x^(2m - 2) / (1 + x^2m) from 0 on, which is
(pi / 2m) / sin((2m - 1) pi / 2m).
"""


def velocity_noise(position_noise: float, cutoff_hz: float, sample_rate_hz: float) -> float:
    """Standard deviation of the velocity, per s, that white position noise leaves below a cutoff."""
    share = math.sqrt(min(1.0, 2.0 * cutoff_hz / sample_rate_hz))
    return position_noise * 2.0 * math.pi * cutoff_hz / math.sqrt(3.0) * share


@dataclass(frozen=True)
class SharpVelocity:
    """Velocity (n,), as sharp at reversals as the encoder allows, and `half_width` (n,): what it changes by within half
    a sample, or what the encoder cannot resolve, whichever is more. In units per s.

    `rounding` (n,), s: at a reversal with friction over inertia of c (units per s^2) the low-pass took `rounding` c off
    the velocity; positive where the motion turns upwards, negative where it turns downwards, zero between.
    `acceleration` (n,), per s^2: its size.
    """

    velocity: Floats
    half_width: Floats
    rounding: Floats
    acceleration: Floats

    def direction(self) -> Floats:
        """Sign of the velocity (n,), -1 to 1, averaged over the sample it stands for."""
        direction: Floats = np.clip(self.velocity / self.half_width, -1.0, 1.0)
        return direction

    def kink(self, jump: float, *, speed: float = 0.0, way: float = 0.0) -> Floats:
        """What the low-pass took off the velocity (n,) at reversals, for dry friction over inertia `jump`, per s^2.

        Friction that turns over with `speed` (tanh) or with `way` rounds the kink off itself, and less is lost.
        """
        size = np.abs(self.rounding)
        own = math.log(2.0) * speed / self.acceleration + np.sqrt(0.5 * way / self.acceleration)
        lost: Floats = jump * np.sign(self.rounding) * (np.hypot(size, own) - own)
        return lost


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
    sharpest, cutoffs = velocity, np.full(n, lowest_hz)
    cutoff = CUTOFF_RATIO * lowest_hz
    while cutoff < 0.45 * rate:
        spread = velocity_noise(noise, cutoff, rate)
        fast = spread < NOISE_SHARE * speed
        if not fast.any():
            break
        (sharper,) = SpectralFilter(n, rate, cutoff)(position, (1,))
        sharpest = np.where(fast, sharper, sharpest)
        width = np.where(fast, UNSURE * spread, width)
        cutoffs = np.where(fast, cutoff, cutoffs)
        cutoff *= CUTOFF_RATIO
    width = np.maximum(width, np.maximum(0.5 * np.abs(acceleration) / rate, 1e-12))
    rounding = _turning(sharpest, REACH_PERIODS * rate / cutoffs) * KINK_ROUNDED / cutoffs
    return SharpVelocity(sharpest, width, rounding, np.maximum(np.abs(acceleration), 1e-12))


def _turning(velocity: Floats, reach: Floats) -> Floats:
    """Which way (n,) the motion turns at the nearest reversal within `reach` (n,) samples: 1 up, -1 down, 0 none."""
    turns = np.flatnonzero(velocity[:-1] * velocity[1:] <= 0.0)
    if turns.size == 0:
        return np.zeros_like(velocity)
    at, middles = np.arange(velocity.size), turns + 0.5
    after = np.clip(np.searchsorted(middles, at), 0, turns.size - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(middles[before] - at) < np.abs(middles[after] - at), before, after)
    way = np.sign(velocity[turns + 1] - velocity[turns])
    turning: Floats = np.where(np.abs(middles[nearest] - at) <= reach, way[nearest], 0.0)
    return turning
