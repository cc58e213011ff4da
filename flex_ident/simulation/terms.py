"""The terms that the simulation knows, as one vector: what base parameters and effects write into."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from flex_ident.recording import Floats


class Term(IntEnum):
    """Position of each physical term in the vector (SI, link side). Zero switches a term off."""

    # the spring between motor and link
    STIFFNESS = 0
    CUBIC_STIFFNESS = 1
    HALF_GAP = 2
    HYSTERESIS_TORQUE = 3
    HYSTERESIS_DEFLECTION = 4
    SPRING_DAMPING = 5
    # the link
    LINK_INERTIA = 6
    LINK_VISCOUS = 7
    LINK_COULOMB = 8
    GRAVITY_COS = 9
    """First moment times g, N m: multiplies cos q."""
    GRAVITY_SIN = 10
    LINK_VISCOUS_ASYMMETRY = 11
    LINK_VISCOUS_QUADRATIC = 12
    LINK_STRIBECK = 13
    LINK_STRIBECK_VELOCITY = 14
    LINK_LOAD_FRICTION = 15
    # a further mass on the link
    SECOND_INERTIA = 16
    SECOND_STIFFNESS = 17
    SECOND_DAMPING = 18
    # friction on both sides
    FRICTION_RATE = 19
    # the motor
    MOTOR_INERTIA = 20
    MOTOR_VISCOUS = 21
    MOTOR_COULOMB = 22
    MOTOR_VISCOUS_ASYMMETRY = 23
    MOTOR_VISCOUS_QUADRATIC = 24
    MOTOR_STRIBECK = 25
    MOTOR_STRIBECK_VELOCITY = 26
    MOTOR_LOAD_FRICTION = 27
    OFFSET = 28
    RIPPLE = 29
    RIPPLE_CYCLES = 30
    RIPPLE_PHASE = 31
    # the transmission between motor angle and spring
    KINEMATIC_ERROR = 32
    KINEMATIC_CYCLES = 33
    KINEMATIC_PHASE = 34
    # the measurement chain and the state at the start
    TORQUE_DELAY = 35
    TORQUE_AVERAGING = 36
    """kappa in recorded = Gamma + kappa Ts^2 Gamma'': +1/24 for a mean over one sample, -1/24 for a held command."""
    LINK_SKEW = 37
    LINK_ZERO = 38
    """Link encoder's zero, rad, against the motor's."""
    TORQUE_LIMIT = 39
    """Zero: no limit."""
    INITIAL_DEFLECTION = 40
    """Deviation of the link's first position from its static equilibrium, rad."""
    INITIAL_VELOCITY = 41
    """Deviation of the link's first velocity from the motor's, rad/s."""
    # how the motor's dry friction turns over at a reversal
    REVERSAL_SPEED = 42
    """Speed, rad/s, over which dry friction grows to its full size: zero is Coulomb's law."""
    PRESLIDING = 43
    """Way, rad, over which dry friction turns over after a reversal (Dahl)."""
    REVERSAL_LEAD = 44
    """Time, s, by which dry friction turns over before the velocity does."""
    EFFORT_LAG = 45
    """Time constant, s, of a first-order low-pass in the recorded torque."""


GRAVITY = 9.81
"""Acceleration of gravity, m/s^2, that turns first moments (kg m) into torque."""

BASE_TERMS: dict[str, tuple[Term, float]] = {
    "Jm": (Term.MOTOR_INERTIA, 1.0),
    "K": (Term.STIFFNESS, 1.0),
    "JL": (Term.LINK_INERTIA, 1.0),
    "FVm": (Term.MOTOR_VISCOUS, 1.0),
    "FSm": (Term.MOTOR_COULOMB, 1.0),
    "FV": (Term.LINK_VISCOUS, 1.0),
    "FS": (Term.LINK_COULOMB, 1.0),
    "MX": (Term.GRAVITY_COS, GRAVITY),
    "MY": (Term.GRAVITY_SIN, GRAVITY),
    "offset": (Term.OFFSET, 1.0),
}
"""Base parameter to term and factor (eqs. 5 to 7)."""

RIGID_TERMS: dict[str, tuple[Term, float]] = {
    "J": (Term.MOTOR_INERTIA, 1.0),
    "FV": (Term.MOTOR_VISCOUS, 1.0),
    "FS": (Term.MOTOR_COULOMB, 1.0),
    "offset": (Term.OFFSET, 1.0),
    "MX": (Term.GRAVITY_COS, GRAVITY),
    "MY": (Term.GRAVITY_SIN, GRAVITY),
}

MEASUREMENT_TERMS: dict[str, tuple[Term, float]] = {
    "torque_delay": (Term.TORQUE_DELAY, 1.0),
    "torque_averaging": (Term.TORQUE_AVERAGING, 1.0),
    "link_skew": (Term.LINK_SKEW, 1.0),
    "link_zero": (Term.LINK_ZERO, 1.0),
    "initial_deflection": (Term.INITIAL_DEFLECTION, 1.0),
    "initial_velocity": (Term.INITIAL_VELOCITY, 1.0),
    "reversal_speed": (Term.REVERSAL_SPEED, 1.0),
    "presliding": (Term.PRESLIDING, 1.0),
    "reversal_lead": (Term.REVERSAL_LEAD, 1.0),
    "effort_lag": (Term.EFFORT_LAG, 1.0),
}


def no_terms() -> Floats:
    """A vector (len(Term),) with every term switched off."""
    return np.zeros(len(Term))
