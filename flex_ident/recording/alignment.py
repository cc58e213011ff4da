"""Signals of different rates, with jitter, lost samples and gaps, brought to one uniform clock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate

from flex_ident.errors import ExcitationError
from flex_ident.recording.recording import Floats, Notice, Recording, Role, Sampling, Signal

UNIFORM = 1e-3
"""Jitter, in periods, below which samples are taken as they stand."""
GAP_PERIODS = 5.0
"""Length of a gap, in periods, from which the bridge over it carries no information."""
FEWEST = 64


def period_of(time: Floats) -> float:
    """The sampling period, s: the slope of time over the count of samples, lost ones counted."""
    steps = np.diff(time)
    median = float(np.median(steps))
    index = np.concatenate((np.zeros(1), np.cumsum(np.maximum(1.0, np.round(steps / median)))))
    # A receive clock can be so irregular that rounding miscounts; then the median is all there is.
    slope = float(np.polyfit(index, time - time[0], 1)[0])
    return slope if abs(slope / median - 1.0) < 0.05 else median


def sampling_of(signal: Signal, motor: Signal) -> Sampling:
    """Rate, jitter, lost samples, longest gap and skew of one signal."""
    steps = np.diff(signal.time)
    period = period_of(signal.time)
    counts = np.maximum(1.0, np.round(steps / period))
    expected = float(counts.sum()) + 1.0
    single = steps[counts == 1.0]
    jitter = float(np.std(single)) / period * 100.0 if single.size else 0.0
    return Sampling(
        role=signal.role,
        source=signal.source,
        clock=signal.clock,
        samples=signal.time.size,
        rate_hz=1.0 / period,
        jitter_percent=jitter,
        lost_percent=100.0 * (expected - signal.time.size) / expected,
        longest_gap_s=float(steps.max()),
        skew_s=_skew(signal.time, motor.time),
        dropped_nonfinite=signal.dropped_nonfinite,
        dropped_duplicates=signal.dropped_duplicates,
        dropped_backwards=signal.dropped_backwards,
    )


def _skew(time: Floats, reference: Floats) -> float:
    """Mean time by which stamps lie behind the nearest stamp of the reference."""
    right = np.clip(np.searchsorted(reference, time), 1, reference.size - 1)
    after, before = reference[right] - time, time - reference[right - 1]
    nearest = np.where(before <= after, before, -after)
    return float(np.mean(nearest))


def _even_time(signal: Signal) -> Floats:
    """The instants at which the samples were taken.

    A header's stamp is such an instant. A receive time is not: there the samples are taken as evenly spaced, lost
    ones counted, unless the times are too irregular to count them.
    """
    if signal.clock == "header":
        return signal.time
    steps = np.diff(signal.time)
    period = period_of(signal.time)
    counts = np.maximum(1.0, np.round(steps / period))
    index = np.concatenate((np.zeros(1), np.cumsum(counts)))
    fitted = np.polyval(np.polyfit(index, signal.time, 1), index)
    if float(np.max(np.abs(fitted - signal.time))) > 0.25 + 20.0 * period:
        return signal.time
    even: Floats = fitted
    return even


def _on_clock(signal: Signal, time: Floats, clock: Floats, period: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Values (n,) at the clock's instants, and where (n,) they rest on samples close by."""
    first = int(np.argmin(np.abs(time - clock[0])))
    direct = time[first : first + clock.size]
    measured = np.ones(clock.size, bool)
    if direct.size == clock.size and float(np.max(np.abs(direct - clock))) < UNIFORM * period:
        return signal.values[first : first + clock.size], measured
    values: Floats = interpolate.CubicSpline(time, signal.values)(clock)
    steps = np.diff(time)
    own_period = float(np.median(steps))
    wide = np.flatnonzero(steps > GAP_PERIODS * max(own_period, period))
    for i in wide:
        inside = (clock > time[i]) & (clock < time[i + 1])
        measured[inside] = False
        values[inside] = np.interp(clock[inside], time, signal.values)
    return values, measured


def aligned_recording(
    signals: list[Signal],
    *,
    joint: str,
    notices: list[Notice] | None = None,
    path: str = "",
    sha256: str = "",
    start_time_s: float = 0.0,
) -> Recording:
    """One recording on the clock of the motor position. Raises ExcitationError when too little overlaps."""
    by_role: dict[Role, Signal] = {signal.role: signal for signal in signals}
    motor = by_role["motor_position"]
    times = {role: _even_time(signal) for role, signal in by_role.items()}
    period = period_of(times["motor_position"])
    start = max(time[0] for role, time in times.items() if role != "reference")
    stop = min(time[-1] for role, time in times.items() if role != "reference")
    motor_time = times["motor_position"]
    first = motor_time[np.searchsorted(motor_time, start - 0.5 * period)]
    first = max(float(first), start) if first < start - UNIFORM * period else float(first)
    n = int(np.floor((stop - first) / period + UNIFORM)) + 1
    if n < FEWEST:
        raise ExcitationError(
            f"joint {joint}: {max(n, 0)} samples in which all signals overlap: record at least ten seconds of motion."
        )
    # The period is refined over the stretch in use, so that even stamps are met to the nanosecond.
    clock: Floats = first + period * np.arange(n, dtype=np.float64)
    measured = np.ones(n, bool)
    values: dict[Role, Floats] = {}
    for role, signal in by_role.items():
        if role == "reference":
            values[role] = np.interp(clock, times[role], signal.values)
            continue
        values[role], here = _on_clock(signal, times[role], clock, period)
        measured &= here
    collected = list(notices or [])
    bridged = 100.0 * float(np.mean(~measured))
    if bridged > 0.0:
        collected.append(
            Notice(
                "gaps", f"{bridged:.2f} % of the recording lies in gaps of over {GAP_PERIODS:.0f} samples: left out."
            )
        )
    return Recording(
        joint=joint,
        sample_rate_hz=1.0 / period,
        motor_position=values["motor_position"],
        motor_torque=values["motor_torque"],
        link_position=values.get("link_position"),
        reference=values.get("reference"),
        measured=measured,
        sampling=tuple(sampling_of(signal, motor) for signal in signals),
        notices=tuple(collected),
        path=path,
        sha256=sha256,
        start_time_s=start_time_s,
    )
