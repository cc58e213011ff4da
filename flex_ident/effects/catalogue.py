"""All known effects, one line each."""

from __future__ import annotations

import math

from flex_ident.effects.backlash import BACKLASH
from flex_ident.effects.cable_torque import CABLE_TORQUE
from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.effort_lag import EFFORT_LAG
from flex_ident.effects.encoder_skew import ENCODER_SKEW
from flex_ident.effects.friction_drift import FRICTION_DRIFT
from flex_ident.effects.gain_drift import GAIN_DRIFT
from flex_ident.effects.gravity import GRAVITY_EFFECT
from flex_ident.effects.hysteresis import HYSTERESIS
from flex_ident.effects.iron_saturation import IRON_SATURATION
from flex_ident.effects.joint_damping import JOINT_DAMPING
from flex_ident.effects.kinematic_error import KINEMATIC_ERROR
from flex_ident.effects.link_encoder_error import LINK_ENCODER_ERROR
from flex_ident.effects.load_dependent_friction import LOAD_DEPENDENT_FRICTION
from flex_ident.effects.motor_angle_curve import MOTOR_ANGLE_CURVE
from flex_ident.effects.motor_encoder_error import MOTOR_ENCODER_ERROR
from flex_ident.effects.motor_friction_curve import MOTOR_FRICTION_CURVE
from flex_ident.effects.mount_mode import MOUNT_MODE
from flex_ident.effects.nonlinear_stiffness import NONLINEAR_STIFFNESS
from flex_ident.effects.offset_drift import OFFSET_DRIFT
from flex_ident.effects.position_dependent_friction import POSITION_DEPENDENT_FRICTION
from flex_ident.effects.position_dependent_stiffness import POSITION_DEPENDENT_STIFFNESS
from flex_ident.effects.presliding_friction import PRESLIDING_FRICTION
from flex_ident.effects.saturation import SATURATION
from flex_ident.effects.second_mode import SECOND_MODE
from flex_ident.effects.soft_zone import SOFT_ZONE
from flex_ident.effects.spring_curve import SPRING_CURVE_EFFECT
from flex_ident.effects.stribeck_friction import STRIBECK_FRICTION
from flex_ident.effects.time_delay import TIME_DELAY
from flex_ident.effects.torque_droop import TORQUE_DROOP
from flex_ident.effects.torque_offset import TORQUE_OFFSET
from flex_ident.effects.torque_ripple import TORQUE_RIPPLE
from flex_ident.effects.viscoelastic_spring import VISCOELASTIC_SPRING
from flex_ident.effects.viscous_asymmetry import VISCOUS_ASYMMETRY
from flex_ident.effects.viscous_nonlinearity import VISCOUS_NONLINEARITY
from flex_ident.errors import ConfigurationError
from flex_ident.parameters.keys import effect_in, key_parts, key_text
from flex_ident.parameters.values import Values

CATALOGUE: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        STRIBECK_FRICTION,
        TORQUE_OFFSET,
        VISCOUS_ASYMMETRY,
        VISCOUS_NONLINEARITY,
        LOAD_DEPENDENT_FRICTION,
        FRICTION_DRIFT,
        POSITION_DEPENDENT_FRICTION,
        GRAVITY_EFFECT,
        CABLE_TORQUE,
        NONLINEAR_STIFFNESS,
        POSITION_DEPENDENT_STIFFNESS,
        BACKLASH,
        HYSTERESIS,
        JOINT_DAMPING,
        TORQUE_RIPPLE,
        KINEMATIC_ERROR,
        TIME_DELAY,
        ENCODER_SKEW,
        SATURATION,
        IRON_SATURATION,
        TORQUE_DROOP,
        GAIN_DRIFT,
        OFFSET_DRIFT,
        SECOND_MODE,
        PRESLIDING_FRICTION,
        MOUNT_MODE,
        EFFORT_LAG,
        SOFT_ZONE,
        MOTOR_ENCODER_ERROR,
        LINK_ENCODER_ERROR,
        VISCOELASTIC_SPRING,
        MOTOR_FRICTION_CURVE,
        MOTOR_ANGLE_CURVE,
        SPRING_CURVE_EFFECT,
    )
}


def effect_named(name: str) -> Effect:
    """The effect of that name. Raises ConfigurationError that lists the catalogue."""
    try:
        return CATALOGUE[name]
    except KeyError:
        raise ConfigurationError(f"unknown effect '{name}': expected one of {', '.join(CATALOGUE)}.") from None


def parameter_named(key: str) -> EffectParameter:
    """The parameter of an effect's key. Raises ConfigurationError on an effect, KeyError on a parameter."""
    effect, name = key_parts(key)
    return effect_named(effect or key).parameter(name)


def is_fixed(key: str) -> bool:
    """Whether a key is given and never fitted. Raises ConfigurationError on an effect, KeyError on a parameter."""
    return effect_in(key) is not None and parameter_named(key).fixed


def told_key(key: str) -> str:
    """A key as people are told of it: of an effect that is a table, the effect's name instead of each point's."""
    effect = CATALOGUE.get(effect_in(key) or "")
    return key if effect is None or effect.curve is None else effect.name


def trade_error(key: str, values: Values) -> float:
    """Standard deviation of a key, as effects among the `values` and base keys stand in for each other."""
    errors = []
    for effect in CATALOGUE.values():
        own = [key_text(effect.name, p.name) for p in effect.parameters]
        if effect.trades_with and key in (*own, *effect.trades_with):
            errors.append(effect.trade_error * values.get(own[0], 0.0))
    return math.hypot(*errors)


def check_effect_parameters(name: str, parameters: dict[str, float]) -> None:
    """Raise ConfigurationError where a parameter is unknown or outside its physical range."""
    effect = effect_named(name)
    known = {p.name: p for p in effect.parameters}
    for key, value in parameters.items():
        if key not in known:
            raise ConfigurationError(f"effect {name} has no parameter '{key}': expected {', '.join(known)}.")
        if not known[key].lower <= value <= known[key].upper:
            text, p = key_text(name, key), known[key]
            raise ConfigurationError(f"{text} is {value}: expected {p.lower} to {p.upper} {p.unit}.")
    why = effect.curve.complaint(parameters) if effect.curve is not None else ""
    if why:
        raise ConfigurationError(f"effect {name} {why}.")
