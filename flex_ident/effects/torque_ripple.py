"""Torque that is periodic in motor angle: cogging, gear mesh."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import FINE, Effect
from flex_ident.effects.harmonics import harmonics
from flex_ident.effects.probe import Probe, Scales, periodic
from flex_ident.simulation.terms import HARMONICS, RIPPLES


def _probes(scales: Scales) -> Iterator[Probe]:
    yield from periodic(scales, scales.torque)


TORQUE_RIPPLE = Effect(
    name="torque_ripple",
    summary="torque periodic in motor angle (cogging, gear mesh)",
    equation="sum of amplitude sin(cycles_per_turn qm + phase) over its harmonics",
    parameters=harmonics("N m", "amplitude of the ripple", RIPPLES),
    probes=_probes,
    refined=("cycles_per_turn", FINE),
    cycles="cycles_per_turn",
    again=HARMONICS,
    where="motor",
    signature="a line in the spectrum of the residual over motor angle",
    bin_by="motor_position",
    confused_with=("kinematic_error", "motor_encoder_error"),
    separated_by="several speeds",
)
