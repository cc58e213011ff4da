"""Whether a position moves at all, or is held: what a held joint's encoder says is noise, or its last digit."""

from __future__ import annotations

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.recording.recording import Floats

STILL = 1e-6
"""A range of positions, rad or m, below which nothing moved."""
FEW_STEPS = 8.0
"""A range in steps of the encoder that no motion to identify from is as small as: a last digit or two that flicker."""
WANDERING = 0.02
"""A range of positions, rad or m, that noise may have: a potentiometer's, or a 12-bit encoder's over some steps."""
UNRELATED = 0.4
"""Von Neumann's ratio, mean squared difference over twice the variance, from which a sample does not tell the next.

It is 1 for white noise, at least 0.5 for white noise that was interpolated onto another clock, and 0.01 and less for a
motion that is sampled as often as it takes to see it.
"""
SEGMENT = 64
TONAL = 8.0
"""Largest over mean power of a segment's spectrum from which it holds a tone: 4 for white noise, 20 for a chirp.

A chirp to near half the rate has samples as unrelated as noise, and is none.
"""


def is_held(position: Floats) -> bool:
    """Whether the positions (n,), rad or m, of a joint are those of one that is held, whatever they are sampled at.

    Held: it spans less than a few steps of its encoder, or it is as small as noise may be and one sample says nothing
    of the next. A value that is repeated, by a slower encoder, counts once.
    """
    span = float(np.ptp(position)) if position.size else 0.0
    if span < STILL:
        return True
    steps = np.abs(np.diff(position))
    changed = steps > 1e-9 * span
    if not changed.any():
        return True
    if span < FEW_STEPS * float(np.min(steps[changed])):
        return True
    fresh = position[np.concatenate(([True], changed))]
    return span < WANDERING and von_neumann_ratio(fresh) > UNRELATED and not _tonal(fresh)


def von_neumann_ratio(values: Floats) -> float:
    """Mean squared difference of successive values (n,) over twice their variance: 1 for white noise."""
    variance = float(np.var(values))
    return float(np.mean(np.diff(values) ** 2)) / (2.0 * variance) if variance > 0.0 else 1.0


def _tonal(values: Floats) -> bool:
    count = values.size // SEGMENT
    if count < 1:
        return False
    segments = values[: count * SEGMENT].reshape(count, SEGMENT)
    segments = (segments - segments.mean(axis=1, keepdims=True)) * np.hanning(SEGMENT)
    power = np.abs(np.fft.rfft(segments, axis=1))[:, 1:] ** 2
    mean = power.mean(axis=1)
    return float(np.median(power.max(axis=1) / np.where(mean > 0.0, mean, 1.0))) > TONAL


def refuse_held(joint: str, position: Floats) -> None:
    """Raises ExcitationError where the positions (n,), rad or m, of a joint are those of one that is held."""
    if is_held(position):
        raise still_error(joint, float(np.ptp(position)) if position.size else 0.0)


def still_error(joint: str, span: float) -> ExcitationError:
    """That a joint does not move, though its positions span so much, rad or m."""
    noise = ", which is noise" if span > 0.0 else ""
    return ExcitationError(
        f"joint {joint} does not move: its position spans {span:.2g} rad{noise}. Record it while it follows a chirp, "
        "or name another one with --joint."
    )
