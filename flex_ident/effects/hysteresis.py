"""Spring torque that depends on the direction of deflection (Dahl)."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    for share in (0.03, 0.1, 0.3, 1.0):
        yield at_size({"torque": 0.02 * scales.load, "deflection": share * scales.deflection}, scaled=("torque",))


HYSTERESIS = Effect(
    name="hysteresis",
    summary="spring torque depends on the direction of deflection",
    equation="tau + torque z, dz/dd = (1 - z sign(d')) / deflection",
    parameters=(
        EffectParameter("torque", "N m", "half the height of the loop", Term.HYSTERESIS_TORQUE, lower=0.0),
        EffectParameter(
            "deflection", "rad", "deflection over which the torque turns round", Term.HYSTERESIS_DEFLECTION, lower=1e-9
        ),
    ),
    probes=_probes,
    where="spring",
    signature="a loop of the residual over deflection that does not depend on speed",
    bin_by="spring_deflection",
    confused_with=("joint_damping",),
    separated_by="the same loop at two speeds",
    needs_spring=True,
)
