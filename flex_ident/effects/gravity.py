"""Gravity that the base model leaves out (eq. 7 of the paper)."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import SMOOTH_PROBE, Probe, Scales
from flex_ident.simulation.terms import GRAVITY, Term


def _probes(scales: Scales) -> Iterator[Probe]:
    moment = SMOOTH_PROBE * scales.torque / GRAVITY
    missing = scales.missing_moments
    if missing:
        columns = tuple({k: moment * (k == own) for k in missing} for own in missing)
        yield Probe(columns, missing, one_sided=False, smooth=True)


GRAVITY_EFFECT = Effect(
    name="gravity",
    summary="first moments that the base model leaves out",
    equation="MX g cos q + MY g sin q",
    parameters=(
        EffectParameter("MX", "kg m", "first moment along the link's x axis", Term.GRAVITY_COS, factor=GRAVITY),
        EffectParameter("MY", "kg m", "first moment along the link's y axis", Term.GRAVITY_SIN, factor=GRAVITY),
    ),
    probes=_probes,
    where="link",
    signature="a residual that depends on position alone",
    bin_by="link_position",
    confused_with=("torque_offset",),
    separated_by="a large range of positions",
    law_error=EXACT,
)
