"""Torque or command recorded early or late against position."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import SAMPLES, Probe, Scales, in_proportion
from flex_ident.effects.starting import Scans, Start, far_off
from flex_ident.simulation.terms import Term

DELAYS_A_PERIOD = 16
"""Delays tried over a period of the end of the band."""


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("delay", SAMPLES * scales.sample_time_s)


def delay_scanned_start(scans: Scans) -> Start:
    """The delay within half a period of the band's end with which a joint explains most. Raises ExcitationError."""
    step = 1.0 / (DELAYS_A_PERIOD * scans.scales.band_hz)
    delays = step * np.arange(-DELAYS_A_PERIOD // 2, DELAYS_A_PERIOD // 2 + 1)
    earlier = np.column_stack([scans.reduced(scans.recorded_torque, delay=-float(d)) for d in delays])
    which, model = scans.scanned(earlier)
    return Start(model, {"delay": float(delays[which])})


def _start(scans: Scans) -> Start | None:
    """A fit that had to do without the delay may be lost."""
    return delay_scanned_start(scans) if far_off(scans) else None


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
    start=_start,
    replaces="torque_delay",
    where="measurement",
    of_recording=True,
    signature="a phase of the residual that grows with frequency",
    bin_by="frequency",
    confused_with=("friction_drift", "joint_damping", "effort_lag"),
    separated_by="a wide band",
    law_error=EXACT,
)
