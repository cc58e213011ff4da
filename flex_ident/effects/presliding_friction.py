"""Dry friction that gives way before it slides: as bristles bend (Dahl, LuGre), or as a simulator's soft constraint.

MuJoCo's friction loss is of the second kind: with `solref` (timeconst, 1) and `solimp` (dmin, dmax, ...) its `time` is
dmax timeconst / 2, and its `softness` 1 / dmin - 1: 9.5 ms and 0.111 as it comes.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.simulation.terms import Term

WAYS = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2)
"""Deflections tried, over the range of the motion."""
SPEEDS = (0.03, 0.1, 0.3)
"""Speeds of the Stribeck curve tried, over the rms speed."""
EXCESS = 0.3
"""Excess at standstill tried, over the dry friction."""
SOFTNESSES, TIMES = (0.03, 0.111, 0.4), (4e-3, 9.5e-3, 2e-2)
"""Soft constraints tried; the middle ones are MuJoCo's."""


def _probes(scales: Scales) -> Iterator[Probe]:
    dry = scales.model.get("FSm", scales.model.get("FS", 0.0))
    if dry <= 0.0:
        return
    for way in WAYS:
        yield at_size({"deflection": way * scales.travel})
    for way, speed in product(WAYS, SPEEDS):
        shape = {"deflection": way * scales.travel, "amplitude": EXCESS * dry, "velocity": speed * scales.speed}
        yield at_size(shape, scaled=("deflection", "amplitude"))
    for softness, time in product(SOFTNESSES, TIMES):
        yield at_size({"softness": softness, "time": time}, scaled=("softness",))


PRESLIDING_FRICTION = Effect(
    name="presliding_friction",
    summary="dry friction bends, or gives way, before it slides",
    equation="F' = s (v - abs(v) F / g), s = g(0) / deflection, g = FSm + amplitude exp(-(v / velocity)^2); or, on "
    "both sides, F = inertia (a + v / time) / softness, at most the dry friction",
    parameters=(
        EffectParameter(
            "deflection", "rad", "motion within which friction bends before it slides", Term.BRISTLE_DEFLECTION,
            lower=0.0,
        ),
        EffectParameter("amplitude", "N m", "excess of dry friction at standstill", Term.BRISTLE_STRIBECK, lower=0.0),
        EffectParameter(
            "velocity", "rad/s", "speed at which the excess has fallen to 1/e", Term.BRISTLE_STRIBECK_VELOCITY,
            lower=1e-9,
        ),
        EffectParameter(
            "softness", "1", "what moves on over what friction holds back", Term.SOFT_FRICTION, lower=0.0, upper=10.0
        ),
        EffectParameter(
            "time", "s", "time in which soft friction stops the joint", Term.SOFT_FRICTION_TIME, lower=1e-4, upper=1.0
        ),
    ),
    probes=_probes,
    where="motor",
    signature="after each reversal torque that turns over with the way moved, not with the speed",
    bin_by="motor_velocity",
    confused_with=("stribeck_friction",),
    essential=("deflection",),
    separated_by="reversals at several speeds, and slow motion",
    stand_ins=("presliding", "reversal_speed", "reversal_lead"),
    shown_by=("presliding", "reversal_lead"),
)  # fmt: skip
