"""Viscous friction that is not proportional to speed."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    for side in scales.sides:
        yield in_proportion(f"coefficient{side}", scales.torque / scales.speed**2)


VISCOUS_NONLINEARITY = Effect(
    name="viscous_nonlinearity",
    summary="viscous friction not proportional to speed",
    equation="coefficient v abs(v)",
    parameters=(
        EffectParameter(
            "coefficient",
            "N m s^2/rad^2",
            "curvature of the friction over speed, negative where it flattens",
            Term.MOTOR_VISCOUS_QUADRATIC,
        ),
        EffectParameter("coefficient_link", "N m s^2/rad^2", "the same on the link", Term.LINK_VISCOUS_QUADRATIC),
    ),
    probes=_probes,
    where="motor",
    signature="a residual odd in velocity and curved",
    bin_by="motor_velocity",
    confused_with=("stribeck_friction",),
    separated_by="higher speed",
)
