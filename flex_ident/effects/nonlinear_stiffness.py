"""A spring that hardens or softens."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("cubic", scales.load / scales.deflection**3)


NONLINEAR_STIFFNESS = Effect(
    name="nonlinear_stiffness",
    summary="hardening or softening spring",
    equation="tau + cubic d^3",
    parameters=(
        EffectParameter(
            "cubic",
            "N m/rad^3",
            "third-order coefficient of the spring, negative where it softens",
            Term.CUBIC_STIFFNESS,
        ),
    ),
    probes=_probes,
    where="spring",
    signature="a residual odd in deflection that grows with its cube",
    bin_by="spring_deflection",
    confused_with=("load_dependent_friction", "backlash"),
    separated_by="two amplitudes",
    needs_spring=True,
)
