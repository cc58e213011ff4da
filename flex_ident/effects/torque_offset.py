"""A constant torque, or Coulomb friction that differs between directions."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    if "offset" not in scales.model:
        yield in_proportion("offset", scales.torque)


TORQUE_OFFSET = Effect(
    name="torque_offset",
    summary="constant torque, or Coulomb friction that differs between directions",
    equation="offset",
    parameters=(EffectParameter("offset", "N m", "constant motor torque", Term.OFFSET),),
    probes=_probes,
    where="motor",
    shown_by=("offset",),
    signature="a constant residual, the same in both directions",
    bin_by="velocity_sign",
    confused_with=("gravity",),
    separated_by="a large range of positions, and standstill from both sides",
    law_error=EXACT,
    imitable=0.3,  # errors of friction and spring are odd in velocity or deflection, this is neither
)
