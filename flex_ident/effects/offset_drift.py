"""A torque that is read ever further off, by as much whatever it is: a strain gauge or an amplifier that warms."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("rate", scales.torque / max(scales.duration_s, 1.0))


OFFSET_DRIFT = Effect(
    name="offset_drift",
    summary="torque read ever further off as the recording goes on (a sensor or an amplifier that warms)",
    equation="recorded = torque + rate t",
    parameters=(EffectParameter("rate", "N m/s", "change of the reading in a second", Term.OFFSET_RATE),),
    probes=_probes,
    where="measurement",
    of_recording=True,
    law_error=EXACT,
    signature="a residual that rises or falls from the start to the end, whatever the joint does",
    bin_by="time",
    confused_with=("gravity", "friction_drift"),
    separated_by="the reading at rest at one position, at the start and at the end",
    imitable=0.3,  # errors of friction and spring follow the motion, this does not
)
