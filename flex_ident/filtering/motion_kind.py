"""What kind of motion a recording holds, where that decides what it can answer: one tone, or one speed."""

from __future__ import annotations

import numpy as np

from flex_ident.filtering.thresholds import (
    LINE_BINS,
    LINE_WIDTH,
    MOVING_SPEED,
    ONE_SPEED,
    ONE_SPEED_SHARE,
    SMOOTHED_S,
    TONE_SHARE,
    TONE_SHARE_OF_TORQUE,
)
from flex_ident.recording import Floats


def single_tone_hz(position: Floats, torque: Floats, rate_hz: float) -> float | None:
    """The frequency, Hz, that motion and torque (n,) at `rate_hz` hold; None where they hold several.

    Nearly all of the velocity's energy and most of the torque's lie about one line. A sweep or a noise through a sharp
    resonance has such a velocity, and no such torque; dry friction has harmonics in the torque.
    """
    velocity = _energy(np.diff(position))
    if not velocity.any():
        return None
    line = int(np.argmax(velocity))
    width = max(LINE_BINS, round(LINE_WIDTH * line))
    about = slice(max(line - width, 0), line + width + 1)
    for energy, least in ((velocity, TONE_SHARE), (_energy(torque[1:]), TONE_SHARE_OF_TORQUE)):
        if float(energy[about].sum()) < least * float(energy.sum()):
            return None
    return line * rate_hz / (position.size - 1)


def _energy(values: Floats) -> Floats:
    """Energy of values (n,) in each bin of their spectrum, without their mean."""
    spectrum: Floats = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(values.size))) ** 2
    return spectrum


def constant_speed(position: Floats, rate_hz: float) -> float | None:
    """The speed, rad/s or m/s, at which a motion (n,) at `rate_hz` goes nearly whenever it goes; None for another."""
    apart = max(1, round(SMOOTHED_S * rate_hz))
    if position.size < 4 * apart:
        return None
    speed = np.abs(position[apart:] - position[:-apart]) * rate_hz / apart
    moving = speed[speed > MOVING_SPEED * float(np.percentile(speed, 99.0))]
    if not moving.size:
        return None
    usual = float(np.median(moving))
    even = float(np.mean(np.abs(moving - usual) < ONE_SPEED * usual))
    return usual if even > ONE_SPEED_SHARE else None
