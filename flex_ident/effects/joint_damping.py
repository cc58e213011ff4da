"""Viscous damping across the spring."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    omega = math.sqrt(scales.model["K"] / scales.model["JL"])
    yield in_proportion("damping", scales.model["K"] / omega, one_sided=True)


JOINT_DAMPING = Effect(
    name="joint_damping",
    summary="viscous damping across the spring",
    equation="tau + damping d'",
    parameters=(
        EffectParameter(
            "damping",
            "N m s/rad",
            "torque through the transmission a rate of deflection",
            Term.SPRING_DAMPING,
            lower=0.0,
        ),
    ),
    probes=_probes,
    where="spring",
    signature="a residual proportional to the rate of deflection, largest at resonance",
    bin_by="deflection_rate",
    confused_with=("hysteresis", "time_delay"),
    separated_by="a wide band",
    needs_spring=True,
)
