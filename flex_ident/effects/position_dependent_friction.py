"""Dry friction that is larger at some angles of the motor than at others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from flex_ident.effects.effect import FINE, Effect
from flex_ident.effects.harmonics import harmonics
from flex_ident.effects.probe import SMOOTH_PROBE, Probe, Scales
from flex_ident.notices import Reason, Why
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import FRICTION_WAVES, HARMONICS

PERIODS = np.concatenate((np.geomspace(0.4, 2.0, 6), np.arange(2.4, 10.0, 0.45)))
"""Periods over the range of motion that are tried, at most what the band carries: half a period apart they would be
alike no longer."""
MOST = 1.2
"""Amplitude over the dry friction that it is a part of: friction is not negative, within what is known of both."""


def _probes(scales: Scales) -> Iterator[Probe]:
    whole = 2.0 * math.pi / scales.travel
    for cycles in PERIODS[PERIODS * whole <= max(4.0 * whole, scales.most_cycles)] * whole:
        sine = {"amplitude": SMOOTH_PROBE * scales.torque, "cycles_per_turn": float(cycles), "phase": 0.0}
        yield Probe((sine, {**sine, "phase": 0.5 * math.pi}), ("amplitude",), one_sided=False, smooth=True, phased=True)


def _reach(own: Mapping[str, float], model: Values) -> Reason | None:
    dry = model.get("FSm", model.get("FS", 0.0))
    largest = max(own.get(f"amplitude{n}", 0.0) for n in HARMONICS)
    if largest <= MOST * dry:
        return None
    return Reason(Why.VARIES_BEYOND_FRICTION, numbers={"varies": largest, "dry": dry})


POSITION_DEPENDENT_FRICTION = Effect(
    name="position_dependent_friction",
    summary="dry friction that varies with the motor's angle",
    equation="(sum of amplitude sin(cycles_per_turn qm + phase) over its harmonics) sign(v)",
    parameters=harmonics("N m", "amplitude of the variation", FRICTION_WAVES),
    probes=_probes,
    refined=("cycles_per_turn", FINE),
    cycles="cycles_per_turn",
    whole_periods=False,
    again=HARMONICS,
    reach=_reach,
    where="motor",
    signature="a residual over the motor's angle that changes its sign with the direction of motion",
    bin_by="motor_position",
    confused_with=("torque_ripple", "friction_drift", "load_dependent_friction"),
    separated_by="the same stretch passed slowly in both directions, several times",
)
