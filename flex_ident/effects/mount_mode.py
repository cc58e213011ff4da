"""The base on which the joint stands gives way, and swings under the joint's reaction."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import SMOOTH_PROBE, Probe, Scales
from flex_ident.simulation.terms import Term

LOWEST_HZ, HIGHEST = 3.0, 1.3
"""Lowest frequency of a base that is tried, and the highest, over the band."""
POINTS, RATIOS = 24, (0.01, 0.03, 0.1)
"""Frequencies and damping ratios tried."""
HEAVIER = 1.0 / SMOOTH_PROBE
"""Inertia of the base tried, over the joint's: what it changes is in proportion to its inverse only where that is
small. Tried at ten, a base of 59 times the inertia, which saves 454 in chi-square, promised 25 (`bench/coverage.py
--hidden`, seed 493, recording 28)."""
FINER: tuple[float, ...] = tuple(map(float, np.linspace(-0.2, 0.2, 9)))
"""Relative steps of the stiffness around the best one tried."""


def _probes(scales: Scales) -> Iterator[Probe]:
    inertia = HEAVIER * (scales.model.get("Jm", 0.0) + scales.model["JL"])
    frequencies = np.geomspace(LOWEST_HZ, max(HIGHEST * scales.band_hz, 2.0 * LOWEST_HZ), POINTS)
    for frequency, ratio in product(frequencies, RATIOS):
        omega = 2.0 * math.pi * float(frequency)
        base = {"inertia": inertia, "stiffness": inertia * omega**2, "damping": 2.0 * ratio * inertia * omega}
        yield Probe((base,), tuple(base), inverse=True, smooth=True)


MOUNT_MODE = Effect(
    name="mount_mode",
    summary="the base on which the joint stands gives way",
    equation="(inertia + Jm) b'' + damping b' + stiffness b = link friction - Jm qm'' - tau; all moves by b as well",
    parameters=(
        EffectParameter("inertia", "kg m^2", "inertia of the base", Term.MOUNT_INERTIA, lower=0.0),
        EffectParameter("stiffness", "N m/rad", "stiffness of what holds the base", Term.MOUNT_STIFFNESS, lower=0.0),
        EffectParameter("damping", "N m s/rad", "damping of what holds the base", Term.MOUNT_DAMPING, lower=0.0),
    ),
    probes=_probes,
    refined=("stiffness", FINER),
    where="link",
    signature="a residual around one frequency, in proportion to the reaction of motor and link together",
    bin_by="frequency",
    confused_with=("second_mode",),
    separated_by="an accelerometer on the base, or the same motion with the base clamped or weighted",
    needs_spring=True,
    law_error=EXACT,
)
