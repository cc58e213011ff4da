"""Torque or command recorded early or late against position."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import SAMPLES, Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("delay", SAMPLES * scales.sample_time_s)


TIME_DELAY = Effect(
    name="time_delay",
    summary="torque or command recorded early or late against position",
    equation="torque recorded at t is that of t - delay",
    parameters=(
        EffectParameter(
            "delay", "s", "time by which the torque is recorded late", Term.TORQUE_DELAY, lower=-0.1, upper=0.1
        ),
    ),
    probes=_probes,
    replaces="torque_delay",
    where="measurement",
    signature="a phase of the residual that grows with frequency",
    bin_by="frequency",
    confused_with=("friction_drift", "joint_damping"),
    separated_by="a wide band",
    law_error=EXACT,
)
