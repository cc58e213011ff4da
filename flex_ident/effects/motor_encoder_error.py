"""An error of the motor's encoder that is periodic in its angle: once and twice a turn of the motor."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from flex_ident.effects.effect import EXACT, FINE, Effect
from flex_ident.effects.harmonics import harmonics
from flex_ident.effects.probe import Probe, Scales, periodic
from flex_ident.simulation.terms import HARMONICS, MOTOR_ENCODER_ERRORS

EVERY = 2
"""Of the frequencies that are tried of what is periodic, one in so many: what grows with the square of the frequency
shows where the motion is fast, and that is over a short way, of which lines are wide."""


def _probes(scales: Scales) -> Iterator[Probe]:
    yield from islice(periodic(scales, scales.deflection), 0, None, EVERY)


MOTOR_ENCODER_ERROR = Effect(
    name="motor_encoder_error",
    summary="error of the motor's encoder that is periodic in its angle",
    equation="motor position recorded = qm + sum of amplitude sin(cycles_per_turn qm + phase) over its harmonics",
    parameters=harmonics("rad", "amplitude of the error", MOTOR_ENCODER_ERRORS),
    probes=_probes,
    refined=("cycles_per_turn", FINE),
    cycles="cycles_per_turn",
    again=HARMONICS[: len(MOTOR_ENCODER_ERRORS)],
    where="measurement",
    signature="a line over motor angle that grows with the square of its frequency: inertia of a motion that is none",
    bin_by="motor_position",
    confused_with=("kinematic_error", "torque_ripple"),
    separated_by="several speeds, up to where the motor's inertia outweighs the spring",
    law_error=EXACT,
)
