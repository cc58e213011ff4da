"""Which clock each signal's samples lie on: the header's stamp where it can serve, else the time of reception."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import SignalError
from flex_ident.notices import Code, Notice
from flex_ident.recording.cleaning import cleaned_signal, measurable
from flex_ident.recording.drift import without_drift
from flex_ident.recording.instants import rough_period
from flex_ident.recording.raw import RawSignal as RawSignal
from flex_ident.recording.recording import FASTEST_HZ, Role, Signal, spacing_text
from flex_ident.recording.ticks import evened_ticks, steps_taken_back, taken_when_stamped, tick_ns, within_ticks

OTHER_CLOCK = 1_000_000_000
"""Difference in latency, ns, from which two headers are stamped by different clocks."""
INCREASING = 0.5
"""Share of steps that must be positive for stamps to be a clock."""
UNSTAMPED = 0.01
"""Share of messages that may lack a stamp before stamps are given up."""


def usable_stamps(stamps: NDArray[np.int64]) -> bool:
    """Whether header stamps (k,), ns, can serve as the clock: set, and mostly increasing."""
    return stamps.size > 1 and not complaint_of(stamps)


def complaint_of(stamps: NDArray[np.int64]) -> str:
    """Why header stamps (k,), ns, cannot serve as the clock, as in 'stamps are not set'; empty where they can."""
    if np.count_nonzero(stamps == 0) > UNSTAMPED * stamps.size:
        return "are not set"
    steps = np.diff(stamps)
    if float(np.mean(steps > 0)) > INCREASING:
        period = rough_period((stamps - stamps[0]).astype(np.float64) * 1e-9)
        return spacing_text(period) if 0.0 < period < 1.0 / FASTEST_HZ else ""
    if np.count_nonzero(steps < 0) > np.count_nonzero(steps == 0):
        return "decrease"
    return "repeat from message to message" if (steps > 0).any() else "stand still"


def signals_of(
    raw: Mapping[Role, RawSignal], *, joint: str, factors: Mapping[Role, float] | None = None
) -> tuple[list[Signal], list[Notice], float]:
    """The signals in SI on one time axis, what was done to get there, and the axis' origin, s.

    Values are multiplied by their role's factor. Raises SignalError when a signal holds nothing usable.
    """
    if raw["motor_position"].received.size == 0:
        raise SignalError(f"{raw['motor_position'].source} holds no messages: name another signal.")
    notices: list[Notice] = []
    raw = {role: _without_clock_steps(own, notices) for role, own in raw.items()}
    steady = not notices  # what is left of a step that was taken back is no drift
    motor = raw["motor_position"]
    headed = usable_stamps(motor.stamps)
    latency = _latency(motor) if headed else 0
    origin = int(motor.stamps[np.flatnonzero(motor.stamps)[0]] if headed else motor.received[0])
    signals: list[Signal] = []
    for role, own in raw.items():
        if role == "reference" and not measurable(own.values).any():
            continue
        stamped = headed and usable_stamps(own.stamps)
        if stamped:
            own, drifted = without_drift(own, motor) if steady else (own, [])
            notices += [n for n in drifted if n not in notices]
            apart = _latency(own) - latency
            shift = apart if abs(apart) > OTHER_CLOCK else 0
            tick = tick_ns(own.stamps[own.stamps != 0])
            stamps = within_ticks(own.stamps - origin, own.values) if tick else own.stamps - origin
            time = (stamps + shift).astype(np.float64) * 1e-9
            time[own.stamps == 0] = np.nan
            judged = motor if np.array_equal(own.stamps, motor.stamps) else own
            if tick and taken_when_stamped(time, judged.values, 1e-9 * tick):
                tick = 0
            if shift:
                notices.append(Notice(Code.DIFFERENT_CLOCKS, own.source, {"off_s": -shift * 1e-9}))
        else:
            tick = 0
            # Shifted by the usual time from stamp to reception, so that all signals share one axis.
            time = (own.received - (latency + origin)).astype(np.float64) * 1e-9
        clock: Literal["header", "receive"] = "header" if stamped else "receive"
        with np.errstate(invalid="ignore", over="ignore"):  # damage can leave any bits in a number
            values = own.values * (factors or {}).get(role, 1.0)
        time.flags.writeable = values.flags.writeable = False
        signal, dropped = cleaned_signal(role, own.source, clock, time, values)
        if tick:
            signal = replace(signal, time=evened_ticks(signal.time, 1e-9 * tick))
            notices.append(Notice(Code.COARSE_STAMPS, own.source.partition(":")[0], {"tick_ms": tick * 1e-6}))
        signals.append(signal)
        notices += dropped
    why = complaint_of(motor.stamps) if motor.stamps.size > 1 else "are not set"
    notices += _clock_notices([s for s in signals if s.role != "reference"], joint, latency, why)
    return signals, notices, origin * 1e-9


def _without_clock_steps(raw: RawSignal, notices: list[Notice]) -> RawSignal:
    """The signal with stamps of a clock that was never set; what was done is added to the notices."""
    stamps, steps = steps_taken_back(raw.stamps, raw.received)
    if not steps:
        return raw
    sizes = {"steps": len(steps), "largest_ms": 1e-6 * max(steps, key=abs)}
    notice = Notice(Code.CLOCK_STEPPED, raw.source.partition(":")[0], sizes)
    if notice not in notices:
        notices.append(notice)
    return replace(raw, stamps=stamps)


def _latency(raw: RawSignal) -> int:
    """Usual time from stamp to reception, ns."""
    return int(np.median(raw.received - raw.stamps))


def _clock_notices(signals: list[Signal], joint: str, latency: int, why: str) -> list[Notice]:
    received = [s.source for s in signals if s.clock == "receive"]
    if not received:
        return []
    if len(received) == len(signals):
        return [Notice(Code.RECEIVE_TIMES, joint, texts={"why": why})]
    return [Notice(Code.MIXED_CLOCKS, ", ".join(received), {"latency_ms": latency * 1e-6})]
