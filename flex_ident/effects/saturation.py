"""Commanded effort that the drive did not deliver."""

from __future__ import annotations

from collections.abc import Mapping

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term


def _contribute(terms: Floats, p: Mapping[str, float]) -> None:
    terms[Term.TORQUE_LIMIT] = p.get("limit", 0.0)


SATURATION = Effect(
    name="saturation",
    summary="commanded effort that the drive did not deliver",
    equation="delivered = clip(recorded, -limit, limit)",
    parameters=(EffectParameter("limit", "N m", "largest torque that the drive delivers", lower=0.0),),
    contribute=_contribute,
    where="measurement",
    signature="a residual only where the recorded torque is largest",
    bin_by="recorded_torque",
    confused_with=("torque_ripple",),
    separated_by="a lower amplitude",
    law_error=EXACT,
)
