"""Under which conditions recordings were made, as far as they show them themselves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flex_ident.pooling.thresholds import LEAST_SPREAD
from flex_ident.recording import Recording

ENDS = (1.0, 99.0)
"""Percentiles that stand for the ends of the motion."""
DAY_S = 86400.0
SPEED_S = 0.02
"""Time over which a speed is taken, s."""


def recorded_conditions(recordings: Sequence[Recording]) -> list[dict[str, float]]:
    """Amplitude and mean of the position, rad or m, its rms speed, the direction in which it ended up, in amplitudes,
    the duration, s, and where it has a date the day and the hour of the day (UTC), each recording by itself.

    What differs too little between them to matter is left out: how far a drive follows depends on the joint as well.
    """
    found = [_of_one(recording) for recording in recordings]
    amplitude = float(np.mean([own["amplitude"] for own in found]))
    kept = []
    for name in found[0]:
        values = [own[name] for own in found if name in own]
        size = {"mean position": amplitude, "direction": 1.0, "date": 1.0, "hour of day": 24.0}.get(
            name, float(np.mean(np.abs(values)))
        )
        if len(values) == len(found) and float(np.ptp(values)) > LEAST_SPREAD * size:
            kept.append(name)
    return [{name: own[name] for name in kept} for own in found]


def _of_one(recording: Recording) -> dict[str, float]:
    position = recording.motor_position
    low, high = (float(x) for x in np.percentile(position, ENDS))
    amplitude = 0.5 * (high - low)
    step = max(1, round(SPEED_S * recording.sample_rate_hz))
    speed = np.diff(position[::step]) * recording.sample_rate_hz / step
    found = {
        "amplitude": amplitude,
        "mean position": float(np.mean(position)),
        "speed": float(np.sqrt(np.mean(speed**2))) if speed.size else 0.0,
        "direction": float(position[-1] - position[0]) / max(amplitude, 1e-300),
        "duration": float(recording.time[-1]),
    }
    if recording.start_time_s > 0.0:
        found["date"] = recording.start_time_s / DAY_S
        found["hour of day"] = (recording.start_time_s % DAY_S) / 3600.0
    return found
