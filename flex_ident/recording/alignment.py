"""Signals of different rates, with jitter, lost samples and gaps, brought to one uniform clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flex_ident.errors import ExcitationError, SignalError
from flex_ident.notices import Code, Notice
from flex_ident.recording.instants import evened, grid_index, period_of, rough_period
from flex_ident.recording.magnitudes import magnitude_notices
from flex_ident.recording.noise import resolution
from flex_ident.recording.recording import (
    FASTEST_HZ,
    Floats,
    Recording,
    Role,
    Sampling,
    Signal,
    extent_text,
    more_needed,
    spacing_text,
)
from flex_ident.recording.resampling import GAP_PERIODS, UNIFORM, on_clock

FEWEST = 64
LONGEST_GAP_PERIODS = 20_000.0
"""A pause, in periods, from which a recording is two."""


def sampling_of(signals: list[Signal]) -> tuple[Sampling, ...]:
    """Rate, jitter, lost samples, longest gap and skew of each signal."""
    motor = next(signal for signal in signals if signal.role == "motor_position")
    found: list[Sampling] = []
    for signal in signals:
        same = (f for f, other in zip(found, signals, strict=False) if np.array_equal(other.time, signal.time))
        found.append(_sampling(signal, motor, next(same, None)))
    return tuple(found)


def _sampling(signal: Signal, motor: Signal, same: Sampling | None) -> Sampling:
    """`same` is the sampling of a signal with the same times, if there is one."""
    if same is not None:
        return replace(
            same,
            role=signal.role,
            source=signal.source,
            clock=signal.clock,
            dropped_nonfinite=signal.dropped_nonfinite,
            step=resolution(signal.values),
            untold_step=signal.untold_step,
        )
    steps = np.diff(signal.time)
    period = period_of(signal.time)
    index = grid_index(signal.time, period)
    single = steps[np.diff(index) == 1]
    expected = int(index[-1]) + 1
    return Sampling(
        role=signal.role,
        source=signal.source,
        clock=signal.clock,
        samples=signal.time.size,
        rate_hz=1.0 / period,
        jitter_percent=float(np.std(single)) / period * 100.0 if single.size else 0.0,
        lost_percent=100.0 * (expected - signal.time.size) / expected,
        longest_gap_s=float(steps.max()),
        skew_s=_skew(signal.time, motor.time),
        dropped_nonfinite=signal.dropped_nonfinite,
        dropped_duplicates=signal.dropped_duplicates,
        dropped_backwards=signal.dropped_backwards,
        step=resolution(signal.values),
        untold_step=signal.untold_step,
    )


def _skew(time: Floats, reference: Floats) -> float:
    """Usual time by which stamps lie behind the nearest stamp of the reference, s."""
    if time.size == reference.size and np.array_equal(time, reference):
        return 0.0
    right = np.clip(np.searchsorted(reference, time), 1, reference.size - 1)
    after, before = reference[right] - time, time - reference[right - 1]
    return float(np.median(np.where(before <= after, before, -after)))


def _refuse_too_close(signal: Signal) -> None:
    period = rough_period(signal.time) if signal.time.size > 1 else np.inf
    if period < 1.0 / FASTEST_HZ:
        raise SignalError(
            f"the samples of {signal.source} {spacing_text(period)}, which nothing that samples a joint does: have its "
            "times recorded in s, or thin them out."
        )


def _instants(signals: list[Signal]) -> dict[Role, Floats]:
    """The instants at which each signal was sampled: a header's stamps as they are, receive times made even."""
    done: list[tuple[Floats, Floats]] = []
    instants: dict[Role, Floats] = {}
    for signal in signals:
        known = (even for time, even in done if np.array_equal(time, signal.time))
        even = next(known, None)
        if even is None:
            even = signal.time if signal.clock == "header" else evened(signal.time)
            done.append((signal.time, even))
        instants[signal.role] = even
    return instants


def _span(times: list[Floats], period: float) -> tuple[float, float, list[Notice]]:
    """Start and stop, s, of what all signals cover, without a pause that makes a recording two."""
    start, stop = max(time[0] for time in times), min(time[-1] for time in times)
    notices = []
    for time in times:
        inside = time[(time >= start) & (time <= stop)]
        pauses = np.flatnonzero(np.diff(inside) > LONGEST_GAP_PERIODS * period)
        if not pauses.size:
            continue
        first = np.concatenate(([0], pauses + 1))
        last = np.concatenate((pauses, [inside.size - 1]))
        longest = int(np.argmax(last - first))
        start, stop = inside[first[longest]], inside[last[longest]]
        notices.append(Notice(Code.PAUSED, numbers={"longest_s": stop - start}))
    return float(start), float(stop), notices


def _clock(motor_time: Floats, start: float, stop: float, period: float) -> Floats:
    """Instants (n,), `period` apart, from the first of the motor's samples between `start` and `stop`, s."""
    first = motor_time[min(int(np.searchsorted(motor_time, start - UNIFORM * period)), motor_time.size - 1)]
    n = int(np.floor((stop - first) / period + UNIFORM)) + 1 if stop > start else 0
    clock: Floats = first + period * np.arange(max(n, 0), dtype=np.float64)
    return clock


def aligned_recording(
    signals: list[Signal],
    *,
    joint: str,
    notices: list[Notice] | None = None,
    path: str = "",
    sha256: str = "",
    start_time_s: float = 0.0,
    others: Mapping[str, tuple[Floats, Floats]] | None = None,
    poses: Mapping[str, float] | None = None,
) -> Recording:
    """One recording on the clock of the motor position; `others`: times and positions of other joints; `poses`: their
    mean positions.

    Raises ExcitationError when too little overlaps, SignalError when times cannot be those of samples.
    """
    for signal in signals:
        _refuse_too_close(signal)
    times = _instants(signals)
    period = period_of(times["motor_position"])
    start, stop, paused = _span([time for role, time in times.items() if role != "reference"], period)
    clock = _clock(times["motor_position"], start, stop, period)
    if clock.size < FEWEST:
        raise ExcitationError(
            f"joint {joint}: {extent_text(clock.size, 1.0 / period)} in which all signals overlap: "
            f"{more_needed(clock.size, 1.0 / period)}"
        )
    collected = [*(notices or []), *paused]
    measured = np.ones(clock.size, bool)
    values: dict[Role, Floats] = {}
    for signal in signals:
        if signal.role == "reference":
            values[signal.role] = np.interp(clock, times[signal.role], signal.values)
            continue
        values[signal.role], here = on_clock(times[signal.role], signal.values, clock, period)
        measured &= here
    bridged = 100.0 * float(np.mean(~measured))
    if bridged > 0.0:
        collected.append(Notice(Code.GAPS, numbers={"percent": bridged, "periods": GAP_PERIODS}))
    recording = Recording(
        joint=joint,
        sample_rate_hz=1.0 / period,
        motor_position=values["motor_position"],
        motor_torque=values["motor_torque"],
        link_position=values.get("link_position"),
        reference=values.get("reference"),
        motor_current=values.get("motor_current"),
        measured=measured,
        sampling=sampling_of(signals),
        notices=tuple(collected),
        path=path,
        sha256=sha256,
        start_time_s=start_time_s + float(clock[0]),
        others={name: np.interp(clock, time, position) for name, (time, position) in (others or {}).items()},
        poses=poses or {},
    )
    return replace(recording, notices=(*recording.notices, *magnitude_notices(recording)))
