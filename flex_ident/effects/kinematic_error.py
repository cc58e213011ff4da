"""Transmission error that is periodic in motor angle."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import FINE, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, periodic
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    yield from periodic(scales, scales.deflection)


KINEMATIC_ERROR = Effect(
    name="kinematic_error",
    summary="transmission error periodic in motor angle",
    equation="d = qm + e - q, e = amplitude sin(cycles_per_turn qm + phase); the motor bears tau (1 + de/dqm)",
    parameters=(
        EffectParameter("amplitude", "rad", "amplitude of the error", Term.KINEMATIC_ERROR, lower=0.0),
        EffectParameter("cycles_per_turn", "1", "periods in a turn of the joint", Term.KINEMATIC_CYCLES, lower=0.1),
        EffectParameter("phase", "rad", "phase at position zero", Term.KINEMATIC_PHASE, angle=True),
    ),
    probes=_probes,
    refined=("cycles_per_turn", FINE),
    cycles="cycles_per_turn",
    where="spring",
    signature="a line over motor angle that passes through the spring: it grows at resonance",
    bin_by="motor_position",
    confused_with=("torque_ripple",),
    separated_by="a link encoder, and crossing the resonance at several speeds",
    needs_spring=True,
)
