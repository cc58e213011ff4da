"""The key of every parameter: base, measurement chain and effects alike."""

from __future__ import annotations

import math

from flex_ident.effects.catalogue import effect_named
from flex_ident.errors import ConfigurationError
from flex_ident.parameters import LOGARITHMIC, MEASUREMENT_UNITS, NON_NEGATIVE, UNITS
from flex_ident.parameters.keys import Key, key_parts
from flex_ident.parameters.parameter import FAR_MODE
from flex_ident.simulation.terms import BASE_TERMS, MEASUREMENT_TERMS, RIGID_TERMS


def key_named(text: str, *, rigid: bool = False) -> Key:
    """The key that is written so. Raises ConfigurationError.

    `rigid`: friction and gravity of a rigid joint act on its motor, those of one with a spring on the link.
    """
    effect, name = key_parts(text)
    if effect is None:
        return _base_key(name, rigid=rigid)
    try:
        p = effect_named(effect).parameter(name)
    except KeyError:
        raise ConfigurationError(f"unknown parameter {text}.") from None
    return Key(effect, name, p.unit, p.lower, p.upper, False, p.term.force, p.term.side)


def _base_key(name: str, *, rigid: bool) -> Key:
    if name == FAR_MODE:
        return Key(None, name, "", -math.inf, math.inf, False, False, "link")
    terms = {**RIGID_TERMS, **MEASUREMENT_TERMS} if rigid else {**RIGID_TERMS, **BASE_TERMS, **MEASUREMENT_TERMS}
    if name not in terms:
        raise ConfigurationError(f"unknown parameter {name}.")
    term, lowest = terms[name][0], 0.0 if name in NON_NEGATIVE else -math.inf
    unit = UNITS.get(name, MEASUREMENT_UNITS.get(name, ""))
    return Key(None, name, unit, lowest, math.inf, name in LOGARITHMIC, term.force, term.side)
