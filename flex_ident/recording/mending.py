"""What robots really publish, made fit for a fit: each fault found, repaired or left out, counted and said.

On signals that have none of these faults, nothing is changed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flex_ident.notices import Code, Notice
from flex_ident.recording.holds import Freeze, freezes, fresh, measured_at, samples_per_update
from flex_ident.recording.instants import rough_period
from flex_ident.recording.outliers import put_in_between, spikes
from flex_ident.recording.recording import SLOW_HZ, Floats, Role, Signal
from flex_ident.recording.seams import continued
from flex_ident.recording.truncation import effort_grid, untruncated

MEASURED: tuple[Role, ...] = ("motor_position", "link_position", "motor_torque")
EFFORTS: tuple[Role, ...] = ("motor_torque", "motor_current")
POSITIONS: tuple[Role, ...] = ("motor_position", "link_position")
ALIKE = 0.1
"""Difference of two signals' samples to an update, of those, up to which they are measured together."""
STEPPED = 0.8
"""Share of the effort's samples beyond which what repeats is no fault: a torque that is commanded in steps."""
MANY = 0.2
"""Share of the messages from which a constant in between comes from a second publisher."""


def mended_signals(
    signals: list[Signal], factors: Mapping[Role, float] | None = None
) -> tuple[list[Signal], list[Notice]]:
    """The signals without outliers, seams, repeats and freezes, and what was done.

    `factors` are what positions were multiplied by: they say how large a turn of the encoder is.
    """
    notices: list[Notice] = []
    whole = [_without_constants(s, notices) if s.role in MEASURED else s for s in signals]
    found: dict[Role, Signal] = {}
    for own in _without_repeats(whole, notices):
        if own.role in POSITIONS:
            own = _without_seams(own, 2.0 * math.pi * (factors or {}).get(own.role, 1.0), notices)
        if own.role in MEASURED:
            own = _without_spikes(own, notices)
        if own.role in EFFORTS:
            own = _untruncated(own, notices)
        found[own.role] = own
    if "motor_torque" in found:
        found["motor_torque"] = _without_freezes(found["motor_torque"], found["motor_position"], notices)
    return list(found.values()), notices


def _kept(signal: Signal, kept: NDArray[np.bool_]) -> Signal:
    return replace(signal, time=signal.time[kept], values=signal.values[kept])


def _without_constants(signal: Signal, notices: list[Notice]) -> Signal:
    total = signal.values.size
    between, constant = put_in_between(signal.values)
    count = int(np.count_nonzero(between))
    if count:
        sizes = {"count": count, "total": total, "constant": constant}
        case = "second_publisher" if count > MANY * total else "few"
        notices.append(Notice(Code.ISOLATED_VALUES, signal.source, sizes, {"case": case}))
        signal = _kept(signal, ~between)
    return signal


def _without_spikes(signal: Signal, notices: list[Notice]) -> Signal:
    total = signal.values.size
    lone = spikes(signal.values, signal.role)
    count = int(np.count_nonzero(lone))
    if count:
        notices.append(Notice(Code.SPIKES, signal.source, {"count": count, "total": total}))
        signal = _kept(signal, ~lone)
    return signal


def _untruncated(signal: Signal, notices: list[Notice]) -> Signal:
    grid = effort_grid(signal.values)
    if grid is None or grid.cut is False:
        return signal
    if grid.cut is None:
        return replace(signal, untold_step=grid.step)
    notices.append(Notice(Code.EFFORT_TRUNCATED, signal.source, {"step": grid.step}))
    return replace(signal, values=untruncated(signal.values, grid.step))


def _without_seams(signal: Signal, turn: float, notices: list[Notice]) -> Signal:
    jumps = continued(signal.time, signal.values, turn)
    if jumps.count:  # a spike that is two samples long is two jumps
        said: list[Notice] = []
        without = _without_spikes(signal, said)
        others = continued(without.time, without.values, turn)
        if said and not (jumps.seam and others.count):
            notices += said
            signal, jumps = without, others
    if not jumps.count:
        return signal
    if jumps.seam:
        sizes = {"jumps": jumps.count, "size": jumps.size}
        notices.append(Notice(Code.POSITION_UNWRAPPED, signal.source, sizes, {"case": "seam"}))
    else:
        sizes = {"jumps": jumps.count, "largest": jumps.size}
        notices.append(Notice(Code.POSITION_REZEROED, signal.source, sizes))
    return replace(signal, values=jumps.values)


def _without_freezes(torque: Signal, motor: Signal, notices: list[Notice]) -> Signal:
    """The torque without stretches in which it stands still while the joint moves; as it is where that is most."""
    position: Floats = np.interp(torque.time, motor.time, motor.values)
    stretches: list[Freeze] = freezes(torque.values, position, rough_period(torque.time))
    if not stretches:
        return torque
    kept = np.ones(torque.values.size, bool)
    seconds = 0.0
    for stretch in stretches:
        kept[stretch.start + 1 : stretch.stop] = False
        seconds += float(torque.time[stretch.stop - 1] - torque.time[stretch.start])
    dropped = int(np.count_nonzero(~kept))
    if dropped > STEPPED * kept.size:
        return torque
    sizes = {"stretches": len(stretches), "seconds": seconds, "count": dropped, "total": kept.size}
    notices.append(Notice(Code.EFFORT_FROZEN, torque.source, sizes))
    return _kept(torque, kept)


def _without_repeats(signals: list[Signal], notices: list[Notice]) -> list[Signal]:
    """Signals without samples that repeat others; what was measured together is told by what changes most."""
    ratios = {s.role: samples_per_update(s.values) if s.role in MEASURED else 1.0 for s in signals}
    anew = {s.role: fresh(s.values, ratios[s.role]) for s in signals if ratios[s.role] > 1.0}
    found = []
    for signal in signals:
        if signal.role not in anew:
            found.append(signal)
            continue
        ratio = ratios[signal.role]
        together = [s for s in signals if s.role in anew and _held_alike(s, signal, ratios)]
        best = max(together, key=lambda s: int(np.count_nonzero(np.diff(s.values))))
        kept = anew[best.role]
        rate, count = 1.0 / rough_period(signal.time), int(np.count_nonzero(~kept))
        sizes = {"stamped_hz": rate, "measured_hz": rate / ratio, "count": count, "total": kept.size}
        case = "slow" if rate / ratio < SLOW_HZ else "fast"
        notices.append(Notice(Code.HELD_SAMPLES, signal.source, sizes, {"case": case}))
        own = _kept(signal, kept)
        values = [other.values[kept] for other in together]
        found.append(replace(own, time=measured_at(own.time, ratio / rate, values)))
    return found


def _held_alike(one: Signal, other: Signal, ratios: Mapping[Role, float]) -> bool:
    """Whether two signals are measured together: sampled at the same times, and held as long."""
    alike = abs(ratios[one.role] - ratios[other.role]) < ALIKE * ratios[other.role]
    return alike and one.time.size == other.time.size and bool(np.array_equal(one.time, other.time))
