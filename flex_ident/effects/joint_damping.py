"""Viscous damping across the spring."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size, in_proportion
from flex_ident.effects.starting import Scans, Start
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import Term

LEAST_FRICTION = 0.05
"""Share of the link's viscous friction that is left when damping takes its part over."""
USUAL_LOSS = 0.01
"""Loss factor that may be in any spring, one standard deviation, set by hand: steel in torsion loses less, a strain
wave gear more."""


def _probes(scales: Scales) -> Iterator[Probe]:
    omega = math.sqrt(scales.model["K"] / scales.model["JL"])
    yield in_proportion("damping", scales.model["K"] / omega, one_sided=True)


def _start(scans: Scans) -> Start | None:
    """The damping that a skew of the encoders and the link's friction stood in for."""
    values = scans.values
    damping = -values.get("link_skew", 0.0) * values["K"]
    if damping <= 0.0:
        return None
    friction = {k: max(v - damping, LEAST_FRICTION * v) for k, v in values.items() if k == "FV"}
    return Start(values | friction | {"link_skew": 0.0}, {"damping": damping})


def _unseen(model: Values) -> tuple[Probe, ...]:
    """Of a spring without it: the usual loss at the locked-motor frequency."""
    if "joint_damping" in model.effects or not 0.0 < model.get("K", 0.0) < math.inf or not model["JL"] > 0.0:
        return ()
    return (at_size({"damping": USUAL_LOSS * math.sqrt(model["K"] * model["JL"])}),)


JOINT_DAMPING = Effect(
    name="joint_damping",
    summary="viscous damping across the spring",
    equation="tau + damping d'",
    parameters=(
        EffectParameter(
            "damping",
            "N m s/rad",
            "torque through the transmission a rate of deflection",
            Term.SPRING_DAMPING,
            lower=0.0,
        ),
    ),
    probes=_probes,
    unseen=_unseen,
    start=_start,
    trades_with=("FV", "FVm"),
    trade_error=0.03,  # it, friction on either side and the encoders' instants: found on two plants, not the model
    where="spring",
    signature="a residual proportional to the rate of deflection, largest at resonance",
    bin_by="deflection_rate",
    confused_with=("hysteresis", "time_delay"),
    separated_by="a wide band",
    needs_spring=True,
)
