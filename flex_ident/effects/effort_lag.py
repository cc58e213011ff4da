"""Effort behind the low-pass of its driver."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import SAMPLES, Probe, Scales, in_proportion
from flex_ident.effects.starting import Scans, Start, far_off
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import Term

LONGEST_S = 0.2
"""A low-pass of 0.8 Hz: behind a longer one there is no effort of the motion left."""
LAGS = np.geomspace(0.1, 10.0, 13)
"""Time constants scanned for a start, over that of a low-pass at the end of the band."""


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("time", SAMPLES * scales.sample_time_s, one_sided=True)


def _start(scans: Scans) -> Start | None:
    """The time constant without which a joint explains most of the effort: a fit that had to do with it may be lost."""
    if not far_off(scans):
        return None
    lags = LAGS / (2.0 * math.pi * scans.scales.band_hz)
    undone = np.column_stack([scans.reduced(scans.recorded_torque, lag=-float(lag)) for lag in lags])
    sizes = np.linalg.norm(undone, axis=0)  # undoing more of it makes more of the noise: errors are compared by share
    which, model = scans.scanned(undone / sizes)
    return Start(Values({k: v * float(sizes[which]) for k, v in model.items()}), {"time": float(lags[which])})


EFFORT_LAG = Effect(
    name="effort_lag",
    summary="effort behind the low-pass of its driver",
    equation="recorded + time d(recorded)/dt = torque",
    parameters=(
        EffectParameter(
            "time", "s", "time constant of the low-pass on the effort", Term.EFFORT_LAG, lower=0.0, upper=LONGEST_S
        ),
    ),
    probes=_probes,
    start=_start,
    replaces="effort_lag",
    where="measurement",
    of_recording=True,
    signature="a residual late by the same time at all low frequencies, whose size falls at high ones",
    bin_by="frequency",
    confused_with=("time_delay",),
    separated_by="motion up to the frequency of the low-pass, or the effort as it is before the filter",
    law_error=EXACT,
)
