"""Friction that changes over the recording (warm-up)."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    """Of all friction, and of the motor's alone: its gear warms up, and the link's bearings hardly."""
    unit = 1.0 / max(scales.duration_s, 1.0)
    yield in_proportion("rate", unit)
    if len(scales.sides) > 1:
        yield in_proportion("rate_motor", unit)


FRICTION_DRIFT = Effect(
    name="friction_drift",
    summary="friction changes over the recording (warm-up)",
    equation="all friction times (1 + rate t), or the motor's alone times (1 + rate_motor t)",
    parameters=(
        EffectParameter(
            "rate", "1/s", "relative change of all friction in a second", Term.FRICTION_RATE, lower=-0.1, upper=0.1
        ),
        EffectParameter(
            "rate_motor",
            "1/s",
            "the same of the motor's friction alone",
            Term.MOTOR_FRICTION_RATE,
            lower=-0.1,
            upper=0.1,
        ),
    ),
    probes=_probes,
    where="motor",
    of_recording=True,
    signature="a residual with the sign of the velocity whose size changes with time",
    bin_by="time",
    confused_with=("stribeck_friction", "time_delay"),
    separated_by="repeat the sweep, or run it backwards",
)
