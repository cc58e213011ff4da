"""The motor's friction as it was measured over velocity, where no law of the catalogue is it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flex_ident.effects.curve import Curve, level, line
from flex_ident.effects.effect import Effect
from flex_ident.effects.points import points
from flex_ident.effects.probe import Probe, Scales
from flex_ident.simulation.terms import FRICTION_CURVE, Term

CURVE = Curve(
    variable="motor_velocity",
    at="speed",
    unit="rad/s",
    table=FRICTION_CURVE,
    held={Term.MOTOR_COULOMB: np.sign, Term.MOTOR_VISCOUS: line, Term.OFFSET: level},
    contains=("stribeck_friction", "viscous_asymmetry", "viscous_nonlinearity", "torque_offset"),
    shown=(Term.MOTOR_COULOMB, Term.MOTOR_VISCOUS),
    each_direction=True,
)


def _probes(_: Scales) -> Iterator[Probe]:
    return iter(())


MOTOR_FRICTION_CURVE = Effect(
    name="motor_friction_curve",
    summary="friction of the motor over velocity that is no law of the catalogue, as a measured curve",
    equation="a cubic through torque_n at speed_n, in each direction, added to FSm sign(v) + FVm v",
    parameters=points(CURVE, "velocity of the motor"),
    probes=_probes,
    curve=CURVE,
    priors=CURVE.priors,
    where="motor",
    signature="a residual that is a function of velocity, of no shape that has a name",
    bin_by="motor_velocity",
    confused_with=CURVE.contains,
    separated_by="slow and fast motion at constant speed, in both directions",
    law_error=0.02,
)
