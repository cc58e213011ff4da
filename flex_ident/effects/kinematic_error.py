"""Transmission error that is periodic in motor angle."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import FINE, Effect
from flex_ident.effects.harmonics import harmonics
from flex_ident.effects.probe import Probe, Scales, periodic
from flex_ident.simulation.terms import HARMONICS, KINEMATIC_ERRORS


def _probes(scales: Scales) -> Iterator[Probe]:
    yield from periodic(scales, scales.deflection)


KINEMATIC_ERROR = Effect(
    name="kinematic_error",
    summary="transmission error periodic in motor angle",
    equation="d = qm + e - q, e = sum of amplitude sin(cycles_per_turn qm + phase); the motor bears tau (1 + de/dqm)",
    parameters=harmonics("rad", "amplitude of the error", KINEMATIC_ERRORS),
    probes=_probes,
    refined=("cycles_per_turn", FINE),
    cycles="cycles_per_turn",
    again=HARMONICS,
    where="spring",
    signature="a line over motor angle that passes through the spring: it grows at resonance",
    bin_by="motor_position",
    confused_with=("torque_ripple", "motor_encoder_error"),
    separated_by="a link encoder, and crossing the resonance at several speeds",
    needs_spring=True,
)
