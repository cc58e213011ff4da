"""Viscous damping across the spring."""

from __future__ import annotations

from collections.abc import Mapping

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term


def _contribute(terms: Floats, p: Mapping[str, float]) -> None:
    terms[Term.SPRING_DAMPING] += p.get("damping", 0.0)


JOINT_DAMPING = Effect(
    name="joint_damping",
    summary="viscous damping across the spring",
    equation="tau + damping d'",
    parameters=(
        EffectParameter("damping", "N m s/rad", "torque through the transmission a rate of deflection", lower=0.0),
    ),
    contribute=_contribute,
    where="spring",
    signature="a residual proportional to the rate of deflection, largest at resonance",
    bin_by="deflection_rate",
    confused_with=("hysteresis", "time_delay"),
    separated_by="a wide band",
    needs_spring=True,
)
