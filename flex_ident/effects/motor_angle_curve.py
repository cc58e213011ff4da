"""A torque over the motor's angle as it was measured, where neither gravity nor a ripple is it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flex_ident.effects.curve import Curve, level
from flex_ident.effects.effect import Effect
from flex_ident.effects.points import points
from flex_ident.effects.probe import Probe, Scales
from flex_ident.simulation.terms import ANGLE_CURVE, Term

CURVE = Curve(
    variable="motor_position",
    at="angle",
    unit="rad",
    table=ANGLE_CURVE,
    held={Term.OFFSET: level, Term.GRAVITY_COS: np.cos, Term.GRAVITY_SIN: np.sin},
    contains=("torque_offset",),
)


def _probes(_: Scales) -> Iterator[Probe]:
    return iter(())


MOTOR_ANGLE_CURVE = Effect(
    name="motor_angle_curve",
    summary="torque over the motor's angle that is neither gravity nor a ripple, as a measured curve",
    equation="a cubic through torque_n at angle_n, added to the motor's torque",
    parameters=points(CURVE, "angle of the motor"),
    probes=_probes,
    curve=CURVE,
    priors=CURVE.priors,
    where="motor",
    signature="a residual that is a function of the motor's angle, whatever the speed",
    bin_by="motor_position",
    confused_with=(*CURVE.contains, "torque_ripple", "gravity"),
    separated_by="slow motion over the whole range, to and fro",
    law_error=0.02,
)
