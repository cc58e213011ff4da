"""What is periodic in the motor's angle: a sum of harmonics, each with an amplitude, cycles a turn and a phase."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.terms import KINEMATIC_ERRORS, Term

Harmonics = Sequence[tuple[Term, Term, Term]]


def acting(terms: Floats, harmonics: Harmonics) -> bool:
    """Whether any of the harmonics is not zero."""
    return any(terms[size] != 0.0 for size, *_ in harmonics)


def _those_acting(terms: Floats, harmonics: Harmonics) -> Iterator[tuple[float, float, float]]:
    """Amplitude, cycles a turn and phase of each harmonic that is not zero."""
    for size, cycles, phase in harmonics:
        if terms[size] != 0.0:
            yield float(terms[size]), float(terms[cycles]), float(terms[phase])


def periodic(terms: Floats, harmonics: Harmonics, position: Floats) -> Floats:
    """The sum of the harmonics at `position` (n,), rad."""
    total: Floats = np.zeros_like(position)
    for size, cycles, phase in _those_acting(terms, harmonics):
        total += size * np.sin(cycles * position + phase)
    return total


def periodic_slope(terms: Floats, harmonics: Harmonics, position: Floats) -> Floats:
    """Its derivative by the position (n,)."""
    total: Floats = np.zeros_like(position)
    for size, cycles, phase in _those_acting(terms, harmonics):
        total += size * cycles * np.cos(cycles * position + phase)
    return total


def periodic_bend(terms: Floats, harmonics: Harmonics, position: Floats) -> Floats:
    """Its second derivative by the position (n,)."""
    total: Floats = np.zeros_like(position)
    for size, cycles, phase in _those_acting(terms, harmonics):
        total -= size * cycles**2 * np.sin(cycles * position + phase)
    return total


def transmission_error(terms: Floats) -> bool:
    """Whether the transmission has any periodic error."""
    return acting(terms, KINEMATIC_ERRORS)
