"""Messages of a second publisher: position and effort zero at once, between others that are far from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flex_ident.notices import Code, Notice
from flex_ident.recording.cleaning import measurable
from flex_ident.recording.noise import runs_of_equal
from flex_ident.recording.raw import RawSignal
from flex_ident.recording.recording import Floats, Role

LONGEST_RUN = 12
"""Messages in a row up to which they stand between others; a simulator that rests at zero says so for longer."""
FEWEST_RUNS = 5
FAR = 0.02
"""How far the positions beside such messages must lie off zero, as a rule, in the range of all others."""
MANY = 0.2
"""Share of the messages from which they come from a second publisher."""


def without_empty_messages(raw: Mapping[Role, RawSignal]) -> tuple[dict[Role, RawSignal], list[Notice]]:
    """The signals without messages in which position and effort of the joint are exactly zero, where these stand
    between others that are not; and what was left out. Signals of other topics are as they were."""
    motor, torque = raw["motor_position"], raw["motor_torque"]
    if motor.received.size != torque.received.size or not np.array_equal(motor.received, torque.received):
        return dict(raw), []
    empty = _between(motor.values, (motor.values == 0.0) & (torque.values == 0.0))
    count = int(np.count_nonzero(empty))
    if not count:
        return dict(raw), []
    kept = ~empty
    sizes = {"count": count, "total": empty.size, "constant": 0.0}
    case = {"case": "second_publisher" if count > MANY * empty.size else "few"}
    notices = [Notice(Code.ISOLATED_VALUES, own.source, sizes, case) for own in (motor, torque)]
    return {role: _kept(own, kept) if _together(own, motor) else own for role, own in raw.items()}, notices


def _together(own: RawSignal, motor: RawSignal) -> bool:
    same: bool = own.received.size == motor.received.size and np.array_equal(own.received, motor.received)
    return same


def _kept(raw: RawSignal, kept: NDArray[np.bool_]) -> RawSignal:
    return replace(raw, received=raw.received[kept], stamps=raw.stamps[kept], values=raw.values[kept])


def _between(position: Floats, empty: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which (n,) of the empty messages stand in short runs between positions that are far from zero."""
    none = np.zeros(empty.size, bool)
    others = position[~empty & measurable(position)]
    if not empty.any() or others.size < FEWEST_RUNS:
        return none
    starts, lengths = runs_of_equal(empty.astype(np.float64))
    short = empty[starts] & (lengths <= LONGEST_RUN) & (starts > 0) & (starts + lengths < empty.size)
    starts, lengths = starts[short], lengths[short]
    if starts.size < FEWEST_RUNS:
        return none
    beside = np.minimum(np.abs(position[starts - 1]), np.abs(position[starts + lengths]))
    low, high = np.quantile(others, (0.01, 0.99))
    if not float(np.median(beside)) > FAR * float(high - low):
        return none
    found = none
    for start, length in zip(starts.tolist(), lengths.tolist(), strict=True):
        found[start : start + length] = True
    return found
