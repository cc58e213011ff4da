"""The spring's torque over deflection as it was measured, where it is neither linear nor cubic."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.curve import Curve, line
from flex_ident.effects.effect import Effect
from flex_ident.effects.points import points
from flex_ident.effects.probe import Probe, Scales
from flex_ident.simulation.terms import SPRING_CURVE, Term

CURVE = Curve(
    variable="spring_deflection",
    at="deflection",
    unit="rad",
    table=SPRING_CURVE,
    held={Term.STIFFNESS: line},
    contains=("nonlinear_stiffness", "soft_zone"),
    anchored=True,
    sought=False,  # one of three bands missed the truth (docs/benchmarks.md): where the spring has no torque is open
)


def _probes(_: Scales) -> Iterator[Probe]:
    return iter(())


SPRING_CURVE_EFFECT = Effect(
    name="spring_curve",
    summary="torque of the spring over deflection that is no law of the catalogue, as a measured curve",
    equation="a cubic through torque_n at deflection_n, straight on beyond its ends, added to tau",
    parameters=points(CURVE, "deflection"),
    probes=_probes,
    curve=CURVE,
    priors=CURVE.priors,
    where="spring",
    signature="a residual that is a function of deflection; resonances that move with amplitude",
    bin_by="spring_deflection",
    confused_with=(*CURVE.contains, "backlash"),
    separated_by="slow motion against gravity or a stop, small and large amplitudes",
    needs_spring=True,
    law_error=0.02,
)
