"""The catalogue of physical effects, one file each."""

from flex_ident.effects.catalogue import (
    CATALOGUE,
    check_effect_parameters,
    effect_named,
    is_fixed,
    parameter_named,
    told_key,
    trade_error,
)
from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.keys import key_named
from flex_ident.effects.probe import Probe, Scales

__all__ = [
    "CATALOGUE",
    "Effect",
    "EffectParameter",
    "Probe",
    "Scales",
    "check_effect_parameters",
    "effect_named",
    "is_fixed",
    "key_named",
    "parameter_named",
    "told_key",
    "trade_error",
]
