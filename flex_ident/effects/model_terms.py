"""A model with its effects as the simulation's vector of terms."""

from __future__ import annotations

from flex_ident.effects.catalogue import check_effect_parameters, effect_named
from flex_ident.parameters import JointModel
from flex_ident.recording import Floats
from flex_ident.simulation.terms import BASE_TERMS, RIGID_TERMS, no_terms


def model_terms(model: JointModel) -> Floats:
    """The terms (len(Term),) of base parameters and effects. Raises ConfigurationError on unknown effects."""
    terms = no_terms()
    table = RIGID_TERMS if model.rigid else BASE_TERMS
    for key, value in model.parameters.items():
        terms[table[key][0]] += value * table[key][1]
    for name, parameters in model.effects.items():
        check_effect_parameters(name, dict(parameters))
        effect_named(name).contribute(terms, parameters)
    return terms
