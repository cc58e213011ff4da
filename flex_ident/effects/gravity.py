"""Gravity that the base model leaves out (eq. 7 of the paper)."""

from __future__ import annotations

from collections.abc import Mapping

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.recording import Floats
from flex_ident.simulation.terms import GRAVITY, Term


def _contribute(terms: Floats, p: Mapping[str, float]) -> None:
    terms[Term.GRAVITY_COS] += GRAVITY * p.get("MX", 0.0)
    terms[Term.GRAVITY_SIN] += GRAVITY * p.get("MY", 0.0)


GRAVITY_EFFECT = Effect(
    name="gravity",
    summary="first moments that the base model leaves out",
    equation="MX g cos q + MY g sin q",
    parameters=(
        EffectParameter("MX", "kg m", "first moment along the link's x axis"),
        EffectParameter("MY", "kg m", "first moment along the link's y axis"),
    ),
    contribute=_contribute,
    where="link",
    signature="a residual that depends on position alone",
    bin_by="link_position",
    confused_with=("torque_offset",),
    separated_by="a large range of positions",
    law_error=EXACT,
)
