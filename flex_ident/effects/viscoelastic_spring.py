"""A spring with a part that relaxes: stiffer when it is bent quickly than when it is bent slowly (Maxwell)."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import Term

TIMES = (0.2, 1.0, 5.0, 25.0)
"""Times of relaxation tried, over that of the locked-motor frequency, 1 / (2 pi f)."""
SHARE = 0.1
"""Stiffness of the part tried, over the spring's."""
USUAL_SHARE, USUAL_TIMES = 0.01, (0.2, 1.0, 5.0)
"""What may be in any spring, one standard deviation: a part of that share of its stiffness, as lossy as `joint_damping`
has it, and its times of relaxation."""
SHORTEST_S, LONGEST_S = 1e-4, 100.0
"""A part that relaxes sooner is a damper; one that does so later is a spring."""


def _probes(scales: Scales) -> Iterator[Probe]:
    stiffness = scales.model["K"]
    unit = math.sqrt(scales.model["JL"] / stiffness)
    for time in TIMES:
        yield at_size({"stiffness": SHARE * stiffness, "time": time * unit}, scaled=("stiffness",))


def _unseen(model: Values) -> tuple[Probe, ...]:
    """Of a spring without it: parts that relax about the time of a swing."""
    stiffness = model.get("K", 0.0)
    if "viscoelastic_spring" in model.effects or not 0.0 < stiffness < math.inf or not model["JL"] > 0.0:
        return ()
    unit = math.sqrt(model["JL"] / stiffness)
    parts = ({"stiffness": USUAL_SHARE * stiffness, "time": time * unit} for time in USUAL_TIMES)
    return tuple(at_size(part, scaled=("stiffness",)) for part in parts)


VISCOELASTIC_SPRING = Effect(
    name="viscoelastic_spring",
    summary="spring with a part that relaxes (creep)",
    equation="tau + stiffness y, y' = d' - y / time",
    parameters=(
        EffectParameter(
            "stiffness", "N m/rad", "of the part that relaxes, beside K", Term.RELAXING_STIFFNESS, lower=0.0
        ),
        EffectParameter(
            "time", "s", "time in which it relaxes", Term.RELAXATION_TIME, lower=SHORTEST_S, upper=LONGEST_S
        ),
    ),
    probes=_probes,
    unseen=_unseen,
    where="spring",
    signature="a residual proportional to deflection at high frequencies and to its rate at low ones",
    bin_by="spring_deflection",
    confused_with=("joint_damping", "hysteresis"),
    separated_by="swings of one size, slower and faster than the relaxation",
    needs_spring=True,
)
