"""Viscous friction that is not proportional to speed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term


def _contribute(terms: Floats, p: Mapping[str, float]) -> None:
    terms[Term.MOTOR_VISCOUS_QUADRATIC] += p.get("coefficient", 0.0)
    terms[Term.LINK_VISCOUS_QUADRATIC] += p.get("coefficient_link", 0.0)


def _probes(scales: Scales) -> Iterator[Probe]:
    for side in scales.sides:
        yield in_proportion(f"coefficient{side}", scales.torque / scales.speed**2)


VISCOUS_NONLINEARITY = Effect(
    name="viscous_nonlinearity",
    summary="viscous friction not proportional to speed",
    equation="coefficient v abs(v)",
    parameters=(
        EffectParameter(
            "coefficient", "N m s^2/rad^2", "curvature of the friction over speed, negative where it flattens"
        ),
        EffectParameter("coefficient_link", "N m s^2/rad^2", "the same on the link"),
    ),
    contribute=_contribute,
    probes=_probes,
    where="motor",
    signature="a residual odd in velocity and curved",
    bin_by="motor_velocity",
    confused_with=("stribeck_friction",),
    separated_by="higher speed",
)
