"""Encoders that err by harmonics of their own angle: what is behind what they read, and what they read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.harmonics import acting, periodic, periodic_bend, periodic_slope
from flex_ident.simulation.motion import MotorMotion
from flex_ident.simulation.terms import LINK_ENCODER_ERRORS, MOTOR_ENCODER_ERRORS

PASSES = 3
"""Times that the error is taken at where the motor was found to be: errors are small against their own period."""


def behind_encoder(terms: Floats, motion: MotorMotion) -> MotorMotion:
    """The motor's motion behind an encoder that read `motion`; the same where its encoder does not err."""
    if not acting(terms, MOTOR_ENCODER_ERRORS):
        return motion
    position, fine = (_position_behind(terms, read) for read in (motion.position, motion.fine_position))
    ratio = 1.0 + periodic_slope(terms, MOTOR_ENCODER_ERRORS, position)
    velocity = motion.velocity / ratio
    bend = periodic_bend(terms, MOTOR_ENCODER_ERRORS, position)
    return replace(
        motion,
        position=position,
        velocity=velocity,
        acceleration=(motion.acceleration - bend * velocity**2) / ratio,
        fine_position=fine,
        fine_velocity=motion.fine_velocity / (1.0 + periodic_slope(terms, MOTOR_ENCODER_ERRORS, fine)),
    )


def _position_behind(terms: Floats, read: Floats) -> Floats:
    position = read
    for _ in range(PASSES):
        position = read - periodic(terms, MOTOR_ENCODER_ERRORS, position)
    return position


def link_reading_error(terms: Floats, position: Floats) -> Floats | None:
    """What the link's encoder reads too far at `position` (n,), rad; None where it does not err."""
    if not acting(terms, LINK_ENCODER_ERRORS):
        return None
    return np.asarray(periodic(terms, LINK_ENCODER_ERRORS, position))
