"""Another resonance inside the band."""

from __future__ import annotations

from collections.abc import Mapping

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term


def _contribute(terms: Floats, p: Mapping[str, float]) -> None:
    terms[Term.SECOND_INERTIA] += p.get("inertia", 0.0)
    terms[Term.SECOND_STIFFNESS] += p.get("stiffness", 0.0)
    terms[Term.SECOND_DAMPING] += p.get("damping", 0.0)


SECOND_MODE = Effect(
    name="second_mode",
    summary="another resonance inside the band",
    equation="inertia q2'' = stiffness (q - q2) + damping (q' - q2')",
    parameters=(
        EffectParameter("inertia", "kg m^2", "inertia behind the further spring", lower=0.0),
        EffectParameter("stiffness", "N m/rad", "stiffness of the further spring", lower=0.0),
        EffectParameter("damping", "N m s/rad", "damping across the further spring", lower=0.0),
    ),
    contribute=_contribute,
    where="link",
    signature="a residual concentrated around one frequency above the first mode",
    bin_by="frequency",
    confused_with=("nonlinear_stiffness", "backlash"),
    separated_by="a link encoder",
    needs_spring=True,
    law_error=EXACT,
)
