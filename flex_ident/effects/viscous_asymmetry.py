"""Viscous friction that differs between directions."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    for side in scales.sides:
        yield in_proportion(f"coefficient{side}", scales.torque / scales.speed)


VISCOUS_ASYMMETRY = Effect(
    name="viscous_asymmetry",
    summary="viscous coefficient that differs between directions",
    equation="coefficient abs(v)",
    parameters=(
        EffectParameter(
            "coefficient",
            "N m s/rad",
            "half the difference of the viscous coefficients of both directions",
            Term.MOTOR_VISCOUS_ASYMMETRY,
        ),
        EffectParameter("coefficient_link", "N m s/rad", "the same on the link", Term.LINK_VISCOUS_ASYMMETRY),
    ),
    probes=_probes,
    where="motor",
    signature="a residual even in velocity that grows with speed",
    bin_by="motor_velocity",
    confused_with=("torque_ripple", "torque_offset"),
    separated_by="constant speeds in both directions",
)
