"""The parameters of an effect that is periodic in the motor's angle: a set for each of its harmonics."""

from __future__ import annotations

from collections.abc import Sequence

from flex_ident.effects.effect import EffectParameter
from flex_ident.simulation.terms import HARMONICS, Term


def harmonics(unit: str, meaning: str, terms: Sequence[tuple[Term, Term, Term]]) -> tuple[EffectParameter, ...]:
    """Amplitude in `unit`, cycles a turn and phase for each of the `terms`, under the first suffixes of `HARMONICS`."""
    found = []
    for suffix, (size, cycles, phase) in zip(HARMONICS, terms, strict=False):
        which = f" of harmonic {suffix[1:]}" if suffix else ""
        found += [
            EffectParameter(f"amplitude{suffix}", unit, f"{meaning}{which}", size, lower=0.0),
            EffectParameter(
                f"cycles_per_turn{suffix}", "1", f"periods in a turn of the joint{which}", cycles, lower=0.1
            ),
            EffectParameter(f"phase{suffix}", "rad", f"phase at position zero{which}", phase, angle=True),
        ]
    return tuple(found)
