"""What encoders do to positions: they wrap at a turn, repeat each other, or count the other way round."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flex_ident.errors import SignalError
from flex_ident.notices import Code, Notice
from flex_ident.recording import Floats, Signal
from flex_ident.recording.recording import Role

SAME = 1e-9
"""Difference, relative to the motion, within which two positions are the same number."""
OPPOSITE = -0.9
"""Correlation of motor and link from which one of them counts the other way round."""
JUMP = 0.2
"""By how much the jump of a position that wraps may differ from a turn, in turns."""


def unwrapped(signals: list[Signal], factors: Mapping[Role, float]) -> tuple[list[Signal], list[Notice]]:
    """Positions that jump by a turn of their encoder made continuous; `factors` are what they were multiplied by."""
    found, notices = [], []
    for signal in signals:
        turn = 2.0 * math.pi * abs(factors.get(signal.role, 1.0))
        if signal.role in ("motor_position", "link_position") and _wraps(signal.values, turn):
            notices.append(Notice(Code.POSITION_UNWRAPPED, signal.source, texts={"case": "turn"}))
            signal = replace(signal, values=np.unwrap(signal.values, period=turn))
        found.append(signal)
    return found, notices


def _wraps(values: Floats, turn: float) -> bool:
    """Whether positions stay within one turn and jump from one end of it to the other between two samples."""
    if values.size < 2 or not np.ptp(values) < (1.0 + JUMP) * turn:
        return False
    return bool(np.any(np.abs(np.abs(np.diff(values)) - turn) < JUMP * turn))


def repeats_motor(signals: list[Signal]) -> bool:
    """Whether the link's position is the motor's, number by number, over the gear or not: no second encoder."""
    motor, link = _pair(signals)
    if motor is None or link is None:
        return False
    tolerance = SAME * float(np.ptp(motor.values))
    if motor.values.size == link.values.size and np.allclose(motor.values, link.values, rtol=0.0, atol=tolerance):
        return True
    at, there = _together(motor, link)
    return bool(at.size) and np.allclose(there, at, rtol=0.0, atol=tolerance)


def refuse_opposite(signals: list[Signal]) -> None:
    """Raises SignalError when the link moves against the motor."""
    motor, link = _pair(signals)
    if motor is None or link is None:
        return
    at, there = _together(motor, link)
    if at.size > 2 and np.ptp(at) > 0.0 and np.ptp(there) > 0.0 and np.corrcoef(at, there)[0, 1] < OPPOSITE:
        raise SignalError(
            f"{link.source} moves opposite to {motor.source}: one of them counts the other way round. A negative "
            "--gear-ratio turns the motor's (and a negative --effort-scale its effort); or take --sensors motor."
        )


def _pair(signals: list[Signal]) -> tuple[Signal | None, Signal | None]:
    by_role = {s.role: s for s in signals}
    return by_role.get("motor_position"), by_role.get("link_position")


def _together(motor: Signal, link: Signal) -> tuple[Floats, Floats]:
    """The link's position, and the motor's at the same instants."""
    inside = (link.time >= motor.time[0]) & (link.time <= motor.time[-1])
    return link.values[inside], np.interp(link.time[inside], motor.time, motor.values)
