"""Coulomb friction that grows with the transmitted torque."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    for side in scales.sides:
        yield in_proportion(f"coefficient{side}", 1.0, one_sided=True)


LOAD_DEPENDENT_FRICTION = Effect(
    name="load_dependent_friction",
    summary="Coulomb friction grows with transmitted torque",
    equation="coefficient abs(tau) sign(v)",
    parameters=(
        EffectParameter(
            "coefficient",
            "1",
            "share of the transmitted torque that is lost as friction",
            Term.MOTOR_LOAD_FRICTION,
            lower=0.0,
        ),
        EffectParameter("coefficient_link", "1", "the same on the link", Term.LINK_LOAD_FRICTION, lower=0.0),
    ),
    probes=_probes,
    where="motor",
    signature="a residual proportional to the transmitted torque's size, with the sign of the velocity",
    bin_by="transmitted_torque",
    confused_with=("nonlinear_stiffness", "time_delay", "friction_drift"),
    separated_by="a payload, or another amplitude",
    needs_spring=True,
)
