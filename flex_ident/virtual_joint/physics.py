"""The joint as numbers that the plant integrates: every base parameter and every effect of the catalogue."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel
from flex_ident.parameters.keys import key_text
from flex_ident.recording import Floats

GRAVITY = 9.81


class P(IntEnum):
    """Position of each quantity in the plant's vector; SI, link side of the gear."""

    MOTOR_INERTIA = 0
    STIFFNESS = 1
    LINK_INERTIA = 2
    MOTOR_VISCOUS = 3
    MOTOR_DRY = 4
    LINK_VISCOUS = 5
    LINK_DRY = 6
    MASS_X = 7
    MASS_Y = 8
    CONSTANT = 9
    STRIBECK = 10
    STRIBECK_SPEED = 11
    STRIBECK_LINK = 12
    STRIBECK_SPEED_LINK = 13
    ASYMMETRY = 14
    ASYMMETRY_LINK = 15
    QUADRATIC = 16
    QUADRATIC_LINK = 17
    LOAD_FRICTION = 18
    LOAD_FRICTION_LINK = 19
    WARMING = 20
    CUBIC = 21
    PLAY = 22
    DAHL_TORQUE = 23
    DAHL_DEFLECTION = 24
    SPRING_DAMPING = 25
    DRIVE_LIMIT = 26
    SECOND_INERTIA = 27
    SECOND_STIFFNESS = 28
    SECOND_DAMPING = 29
    TORQUE_DELAY = 30
    LINK_SKEW = 31
    RIPPLE = 32
    RIPPLE_CYCLES = 33
    RIPPLE_PHASE = 34
    RIPPLE_2 = 35
    RIPPLE_CYCLES_2 = 36
    RIPPLE_PHASE_2 = 37
    RIPPLE_3 = 38
    RIPPLE_CYCLES_3 = 39
    RIPPLE_PHASE_3 = 40
    RIPPLE_4 = 41
    RIPPLE_CYCLES_4 = 42
    RIPPLE_PHASE_4 = 43
    RIPPLE_5 = 44
    RIPPLE_CYCLES_5 = 45
    RIPPLE_PHASE_5 = 46
    GEAR_ERROR = 47
    GEAR_CYCLES = 48
    GEAR_PHASE = 49
    GEAR_ERROR_2 = 50
    GEAR_CYCLES_2 = 51
    GEAR_PHASE_2 = 52
    GEAR_ERROR_3 = 53
    GEAR_CYCLES_3 = 54
    GEAR_PHASE_3 = 55
    GEAR_ERROR_4 = 56
    GEAR_CYCLES_4 = 57
    GEAR_PHASE_4 = 58
    GEAR_ERROR_5 = 59
    GEAR_CYCLES_5 = 60
    GEAR_PHASE_5 = 61
    BRISTLE_DEFLECTION = 62
    BRISTLE_STRIBECK = 63
    BRISTLE_STRIBECK_SPEED = 64
    SOFTNESS = 65
    SOFT_TIME = 66
    MOUNT_INERTIA = 67
    MOUNT_STIFFNESS = 68
    MOUNT_DAMPING = 69
    IRON_LOSS = 70
    TORQUE_DROOP = 71
    CABLE_STIFFNESS = 72
    CABLE_TORQUE = 73
    CABLE_COSINE = 74
    CABLE_SINE = 75
    FRICTION_WAVE = 76
    FRICTION_WAVE_CYCLES = 77
    FRICTION_WAVE_PHASE = 78
    FRICTION_WAVE_2 = 79
    FRICTION_WAVE_CYCLES_2 = 80
    FRICTION_WAVE_PHASE_2 = 81
    FRICTION_WAVE_3 = 82
    FRICTION_WAVE_CYCLES_3 = 83
    FRICTION_WAVE_PHASE_3 = 84
    FRICTION_WAVE_4 = 85
    FRICTION_WAVE_CYCLES_4 = 86
    FRICTION_WAVE_PHASE_4 = 87
    FRICTION_WAVE_5 = 88
    FRICTION_WAVE_CYCLES_5 = 89
    FRICTION_WAVE_PHASE_5 = 90
    FRICTION_TABLE = 91
    """Number of points; the place and the torque of each follow."""
    ANGLE_TABLE = 140
    SPRING_TABLE = 189
    EFFORT_LAG = 238
    SOFT_SHARE = 239
    SOFT_DEFLECTION = 240
    RELAXING = 241
    RELAXATION = 242
    MOTOR_ENCODER = 243
    """Amplitude, cycles a turn and phase of the first harmonic of what the encoder reads too far; the others follow."""
    LINK_ENCODER = 258
    GAIN_RATE = 273
    STIFFNESS_COSINE = 274
    STIFFNESS_SINE = 275
    WARMING_MOTOR = 276
    OFFSET_RATE = 277


BASE = {
    "Jm": P.MOTOR_INERTIA, "K": P.STIFFNESS, "JL": P.LINK_INERTIA, "FVm": P.MOTOR_VISCOUS, "FSm": P.MOTOR_DRY,
    "FV": P.LINK_VISCOUS, "FS": P.LINK_DRY, "MX": P.MASS_X, "MY": P.MASS_Y, "offset": P.CONSTANT,
}  # fmt: skip
RIGID = {
    "J": P.MOTOR_INERTIA, "FV": P.MOTOR_VISCOUS, "FS": P.MOTOR_DRY, "offset": P.CONSTANT, "MX": P.MASS_X,
    "MY": P.MASS_Y,
}  # fmt: skip
EFFECTS: dict[str, int] = {
    "stribeck_friction.amplitude": P.STRIBECK,
    "stribeck_friction.velocity": P.STRIBECK_SPEED,
    "stribeck_friction.amplitude_link": P.STRIBECK_LINK,
    "stribeck_friction.velocity_link": P.STRIBECK_SPEED_LINK,
    "torque_offset.offset": P.CONSTANT,
    "viscous_asymmetry.coefficient": P.ASYMMETRY,
    "viscous_asymmetry.coefficient_link": P.ASYMMETRY_LINK,
    "viscous_nonlinearity.coefficient": P.QUADRATIC,
    "viscous_nonlinearity.coefficient_link": P.QUADRATIC_LINK,
    "load_dependent_friction.coefficient": P.LOAD_FRICTION,
    "load_dependent_friction.coefficient_link": P.LOAD_FRICTION_LINK,
    "friction_drift.rate": P.WARMING,
    "friction_drift.rate_motor": P.WARMING_MOTOR,
    "gravity.MX": P.MASS_X,
    "gravity.MY": P.MASS_Y,
    "cable_torque.stiffness": P.CABLE_STIFFNESS,
    "cable_torque.torque": P.CABLE_TORQUE,
    "cable_torque.cosine": P.CABLE_COSINE,
    "cable_torque.sine": P.CABLE_SINE,
    "nonlinear_stiffness.cubic": P.CUBIC,
    "backlash.gap": P.PLAY,
    "viscoelastic_spring.stiffness": P.RELAXING,
    "viscoelastic_spring.time": P.RELAXATION,
    "soft_zone.share": P.SOFT_SHARE,
    "soft_zone.deflection": P.SOFT_DEFLECTION,
    "hysteresis.torque": P.DAHL_TORQUE,
    "hysteresis.deflection": P.DAHL_DEFLECTION,
    "joint_damping.damping": P.SPRING_DAMPING,
    "time_delay.delay": P.TORQUE_DELAY,
    "encoder_skew.skew": P.LINK_SKEW,
    "effort_lag.time": P.EFFORT_LAG,
    "saturation.limit": P.DRIVE_LIMIT,
    "iron_saturation.loss": P.IRON_LOSS,
    "torque_droop.loss": P.TORQUE_DROOP,
    "gain_drift.rate": P.GAIN_RATE,
    "offset_drift.rate": P.OFFSET_RATE,
    "position_dependent_stiffness.cosine": P.STIFFNESS_COSINE,
    "position_dependent_stiffness.sine": P.STIFFNESS_SINE,
    "second_mode.inertia": P.SECOND_INERTIA,
    "second_mode.stiffness": P.SECOND_STIFFNESS,
    "second_mode.damping": P.SECOND_DAMPING,
    "presliding_friction.deflection": P.BRISTLE_DEFLECTION,
    "presliding_friction.amplitude": P.BRISTLE_STRIBECK,
    "presliding_friction.velocity": P.BRISTLE_STRIBECK_SPEED,
    "presliding_friction.softness": P.SOFTNESS,
    "presliding_friction.time": P.SOFT_TIME,
    "mount_mode.inertia": P.MOUNT_INERTIA,
    "mount_mode.stiffness": P.MOUNT_STIFFNESS,
    "mount_mode.damping": P.MOUNT_DAMPING,
}
HARMONIC_SUFFIXES = ("", "_2", "_3", "_4", "_5")
PERIODIC = {
    "torque_ripple": ("RIPPLE", "RIPPLE_CYCLES", "RIPPLE_PHASE"),
    "position_dependent_friction": ("FRICTION_WAVE", "FRICTION_WAVE_CYCLES", "FRICTION_WAVE_PHASE"),
    "kinematic_error": ("GEAR_ERROR", "GEAR_CYCLES", "GEAR_PHASE"),
}
for _effect, _names in PERIODIC.items():
    for _n in HARMONIC_SUFFIXES:
        for _key, _name in zip(("amplitude", "cycles_per_turn", "phase"), _names, strict=True):
            EFFECTS[key_text(_effect, _key + _n)] = P[f"{_name}{_n}"]
ENCODERS = {"motor_encoder_error": int(P.MOTOR_ENCODER), "link_encoder_error": int(P.LINK_ENCODER)}
for _effect, _first in ENCODERS.items():
    for _harmonic, _n in enumerate(("", "_2")):
        for _place, _key in enumerate(("amplitude", "cycles_per_turn", "phase")):
            EFFECTS[key_text(_effect, _key + _n)] = _first + 3 * _harmonic + _place
TABLES = {
    "motor_friction_curve": ("speed", int(P.FRICTION_TABLE)),
    "motor_angle_curve": ("angle", int(P.ANGLE_TABLE)),
    "spring_curve": ("deflection", int(P.SPRING_TABLE)),
}
"""Effects that are tables: what they are over, and where each begins."""
POINTS = 24
SIZE = int(P.OFFSET_RATE) + 1
for _effect, (_at, _first) in TABLES.items():
    for _point in range(POINTS):
        EFFECTS[key_text(_effect, f"{_at}_{_point + 1}")] = _first + 1 + 2 * _point
        EFFECTS[key_text(_effect, f"torque_{_point + 1}")] = _first + 2 + 2 * _point


def plant_values(model: JointModel) -> Floats:
    """The plant's vector (SIZE,) for a model with its effects; a rigid one has no spring and moves as one mass.

    Raises ConfigurationError on inertias that are not positive, and on an effect that it does not know.
    """
    values = np.zeros(SIZE)
    for key, index in (RIGID if model.rigid else BASE).items():
        values[index] += model.parameters.get(key, 0.0)
    for effect, parameters in model.effects.items():
        for name, value in parameters.items():
            key = key_text(effect, name)
            if key not in EFFECTS:
                raise ConfigurationError(f"the virtual joint has no effect parameter '{key}'.")
            values[EFFECTS[key]] += value
        if effect in TABLES:
            values[TABLES[effect][1]] = sum(name.startswith("torque_") for name in parameters)
    for key in ("J",) if model.rigid else ("Jm", "K", "JL"):
        if not model.value(key) > 0.0:
            raise ConfigurationError(f"{key} of the virtual joint is {model.value(key)}: it must be positive.")
    return values
