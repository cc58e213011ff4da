"""Torque that is periodic in motor angle: cogging, gear mesh."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import FINE, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, periodic
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    yield from periodic(scales, scales.torque)


TORQUE_RIPPLE = Effect(
    name="torque_ripple",
    summary="torque periodic in motor angle (cogging, gear mesh)",
    equation="amplitude sin(cycles_per_turn qm + phase)",
    parameters=(
        EffectParameter("amplitude", "N m", "amplitude of the ripple", Term.RIPPLE, lower=0.0),
        EffectParameter("cycles_per_turn", "1", "periods in a turn of the joint", Term.RIPPLE_CYCLES, lower=0.1),
        EffectParameter("phase", "rad", "phase at position zero", Term.RIPPLE_PHASE, angle=True),
    ),
    probes=_probes,
    refined=("cycles_per_turn", FINE),
    cycles="cycles_per_turn",
    where="motor",
    signature="a line in the spectrum of the residual over motor angle",
    bin_by="motor_position",
    confused_with=("kinematic_error",),
    separated_by="several speeds",
)
