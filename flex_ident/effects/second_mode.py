"""Another resonance inside the band."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flex_ident.effects.effect import COARSE, EXACT, Effect, EffectParameter
from flex_ident.effects.probe import SMOOTH_PROBE, Probe, Scales, at_size
from flex_ident.simulation.terms import Term

SHARES = (0.06, 0.2)
"""Inertias tried, over the link's, beside one so small that all changes in proportion to it: tried at 0.06 alone, a
resonance of half a percent, which a leg's recording spoke for by 198 in chi-square, promised 16."""
RACED, FINER = 9, 5
"""Frequencies from which a refit races, with the first of the inertias, less one; and how many times as many are tried
in all: 5 % apart, as a resonance of little damping is narrow."""


def _probes(scales: Scales) -> Iterator[Probe]:
    """Over a grid of frequencies; with a link encoder first the mass that the link's own motion shows."""
    link, stiffness = scales.model["JL"], scales.model["K"]
    seen = scales.link_mode()
    if seen is not None:
        frequency_hz, share = seen
        yield _mass(frequency_hz, link * share / (1.0 + share), 0.02, link, raced=True)
    locked = math.sqrt(stiffness / link) / (2.0 * math.pi)
    highest = max(0.6 * locked, min(5.0 * locked, scales.band_hz))
    for i, frequency in enumerate(np.geomspace(0.6 * locked, highest, 1 + RACED * FINER)):
        yield replace(_mass(float(frequency), SMOOTH_PROBE * link, 0.03, link, raced=False), smooth=True)
        for share in SHARES:
            raced = i % FINER == 0 and share == SHARES[0]
            yield _mass(float(frequency), share * link, 0.03, link, raced=raced)


def _mass(frequency_hz: float, inertia: float, damping_ratio: float, link_inertia: float, *, raced: bool) -> Probe:
    """A part of the link's inertia behind a further spring."""
    omega = 2.0 * math.pi * frequency_hz
    damping = 2.0 * damping_ratio * inertia * omega
    parameters = {"inertia": inertia, "stiffness": inertia * omega**2, "damping": damping}
    return replace(at_size(parameters, JL=link_inertia - inertia), raced=raced)


SECOND_MODE = Effect(
    name="second_mode",
    summary="another resonance inside the band",
    equation="inertia q2'' = stiffness (q - q2) + damping (q' - q2')",
    parameters=(
        EffectParameter("inertia", "kg m^2", "inertia behind the further spring", Term.SECOND_INERTIA, lower=0.0),
        EffectParameter("stiffness", "N m/rad", "stiffness of the further spring", Term.SECOND_STIFFNESS, lower=0.0),
        EffectParameter("damping", "N m s/rad", "damping across the further spring", Term.SECOND_DAMPING, lower=0.0),
    ),
    probes=_probes,
    refined=("stiffness", COARSE),
    raced=True,
    where="link",
    signature="a residual concentrated around one frequency above the first mode",
    bin_by="frequency",
    confused_with=("nonlinear_stiffness", "backlash", "mount_mode"),
    mistaken_for=("mount_mode",),
    essential=("inertia",),
    separated_by="a link encoder, and the base clamped or weighted",
    needs_spring=True,
    stand_ins=("far_mode",),
    law_error=EXACT,
)
