"""Clocks that run at different rates: the stamps of one drift against the times of reception, those of others not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flex_ident.notices import Code, Notice
from flex_ident.recording.raw import RawSignal

BLOCKS = 24
"""Stretches of a recording, of each of which the soonest messages are looked at."""
SOON = 0.1
"""Quantile of the time from stamp to reception within a stretch: waiting adds to it and never takes from it."""
FEWEST = 20
"""Messages that a stretch must have."""
CLEARLY = 6.0
"""Standard deviations from which two clocks differ."""
WORTH = 0.02
"""Drift over the whole recording, in sampling periods, from which it is worth correcting."""
FASTEST = 0.01
"""A drift that no two clocks have: it is something else."""


@dataclass(frozen=True)
class Drift:
    """How fast a clock gains on another, s/s, its standard deviation, and how far it is ahead where `at` is, ns."""

    rate: float
    std: float
    ahead_ns: float
    at: float


def drift_between(one: RawSignal, other: RawSignal) -> Drift | None:
    """How the stamps of a signal gain on those of another, by the times of reception; None where these do not tell."""
    edges = _edges(one, other)
    if edges is None:
        return None
    found = [_latencies(signal, edges) for signal in (one, other)]
    if found[0] is None or found[1] is None:
        return None
    apart = found[1] - found[0]
    middle = 0.5 * (edges[1:] + edges[:-1])
    slope, offset = np.polyfit(middle - middle.mean(), apart, 1)
    left = apart - slope * (middle - middle.mean()) - offset
    spread = float(np.sqrt(np.sum(left**2) / (BLOCKS - 2)))
    std = spread / float(np.sqrt(np.sum((middle - middle.mean()) ** 2)))
    return Drift(float(slope), std, float(offset), float(middle.mean()))


def without_drift(own: RawSignal, motor: RawSignal) -> tuple[RawSignal, list[Notice]]:
    """The signal with stamps that keep pace with the motor position's, and what was done."""
    if own.stamps.size == motor.stamps.size and np.array_equal(own.stamps, motor.stamps):
        return own, []
    drift = drift_between(own, motor)
    if drift is None or not CLEARLY * drift.std < abs(drift.rate) < FASTEST:
        return own, []
    span, period = float(np.ptp(motor.received)), float(np.median(np.diff(motor.received)))
    if abs(drift.rate) * span < WORTH * period:
        return own, []
    ahead = drift.ahead_ns + drift.rate * (own.received.astype(np.float64) - drift.at)
    stamps = np.where(own.stamps == 0, 0, own.stamps - np.rint(ahead).astype(np.int64))
    sizes = {"ppm": 1e6 * drift.rate, "std_ppm": 1e6 * drift.std, "total_ms": 1e-6 * drift.rate * span}
    notice = Notice(Code.CLOCK_DRIFT, own.source.partition(":")[0], sizes, {"case": "stamps"})
    return replace(own, stamps=stamps), [notice]


def _edges(one: RawSignal, other: RawSignal) -> NDArray[np.float64] | None:
    """Times of reception, ns, between which the stretches that both cover lie."""
    if min(one.received.size, other.received.size) < BLOCKS * FEWEST or (one.stamps == 0).any():
        return None
    if (other.stamps == 0).any() or not (np.diff(one.received) >= 0).all() or not (np.diff(other.received) >= 0).all():
        return None
    first, last = max(one.received[0], other.received[0]), min(one.received[-1], other.received[-1])
    return np.linspace(float(first), float(last), BLOCKS + 1) if last > first else None


def _latencies(signal: RawSignal, edges: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The shortest usual time from stamp to reception, ns, in each stretch."""
    latency = (signal.received - signal.stamps).astype(np.float64)
    at = np.searchsorted(signal.received.astype(np.float64), edges)
    if int(np.min(np.diff(at))) < FEWEST:
        return None
    return np.array([np.quantile(latency[a:b], SOON) for a, b in pairwise(at)])
