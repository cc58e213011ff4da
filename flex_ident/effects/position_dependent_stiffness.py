"""A spring whose stiffness varies with the angle: teeth in mesh of a strain wave gear, a cam, a bent coupling."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import SMOOTH_PROBE, Probe, Scales
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    size = SMOOTH_PROBE * scales.model["K"]
    columns = ({"cosine": size, "sine": 0.0}, {"cosine": 0.0, "sine": size})
    yield Probe(columns, ("cosine", "sine"), one_sided=False, smooth=True)


POSITION_DEPENDENT_STIFFNESS = Effect(
    name="position_dependent_stiffness",
    summary="spring whose stiffness varies with the angle of the motor's side",
    equation="tau + (cosine (cos 2q - 1) + sine sin 2q) d, q of the motor's side: K is that at no angle",
    parameters=(
        EffectParameter("cosine", "N m/rad", "times cos 2q - 1", Term.STIFFNESS_COS_2),
        EffectParameter("sine", "N m/rad", "times sin 2q", Term.STIFFNESS_SIN_2),
    ),
    probes=_probes,
    where="spring",
    signature="a residual proportional to deflection whose sign depends on where the joint is",
    bin_by="motor_position",
    confused_with=("viscous_asymmetry", "kinematic_error"),
    separated_by="the same sweep about several positions",
    needs_spring=True,
)
