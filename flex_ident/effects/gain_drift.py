"""A torque that is read larger or smaller as the recording goes on: a magnet or an amplifier that warms."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term

FASTEST = 0.05
"""Relative change in a second, at most. Set by hand, far beyond what warming does: a magnet loses 0.1 to 0.2 % a
kelvin, and a motor that is loaded hard warms by about one kelvin in a second."""
BENT = 0.3
"""Share of the change over a recording by which the gain may be off at its start, one standard deviation. Set by hand:
a gain that settles exponentially with half of the recording starts 0.19 of its change off the straight line, with a
quarter 0.37."""


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("rate", 1.0 / max(scales.duration_s, 1.0))


def _forces_open(parameters: Mapping[str, float], duration_s: float) -> float:
    return BENT * abs(parameters["rate"]) * duration_s


GAIN_DRIFT = Effect(
    name="gain_drift",
    summary="torque read larger or smaller as the recording goes on (a magnet or an amplifier that warms)",
    equation="recorded = torque (1 + rate t)",
    parameters=(
        EffectParameter(
            "rate", "1/s", "relative change of the gain in a second", Term.GAIN_RATE, lower=-FASTEST, upper=FASTEST
        ),
    ),
    probes=_probes,
    where="measurement",
    of_recording=True,
    scales_torque=1.0 + BENT,
    forces_open=_forces_open,
    law_error=EXACT,
    signature="a residual in proportion to the torque whose sign changes in mid-recording",
    bin_by="time",
    confused_with=("friction_drift",),
    separated_by="the same sweep once more, from cold and when all is warm",
)
