"""Whether an effort has lost its sign, or has the opposite one.

An absolute value has corners at zero, where an effort that gravity keeps on one side is flat if it gets there at all.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from flex_ident.errors import SignalError
from flex_ident.recording.recording import Floats, Recording

OTHER_SIDE = 0.03
"""Share of the largest effort by which noise may carry an absolute value to the other side of zero."""
NEAR_ZERO = 0.05
"""Share of the largest effort under which a minimum counts as reaching zero."""
LEGS = (1, 2, 3, 5, 8, 13, 20)
"""Samples to each side of a minimum over which its shape is looked at."""
RISEN = 3.0
"""Of the noise: how far both sides must rise above a minimum for its shape to be seen."""
DRIVES, BRAKES = 0.2, -0.5
"""Share of the work (`work_share`) above which an effort has its sign, and below which it has the opposite one."""
FEWEST_CORNERS = 6
CORNERS = 0.4
"""Share of the minima at zero that must be corners."""
MEETING = 0.25
"""Steps of a sample by which the point where both sides meet may miss zero and the minimum."""
STRAIGHT = 0.5
"""Curvature of a side over the break of slope at the minimum, up to which the minimum is a corner: 0 for straight sides
that meet, 1 for a parabola."""


def refuse_unsigned(recording: Recording) -> None:
    """Raises SignalError where the effort of the recording is an absolute value."""
    corners = corners_at_zero(recording.motor_torque)
    if corners >= FEWEST_CORNERS:
        raise SignalError(
            f"the effort of joint {recording.joint} never changes its sign, and turns round at zero {corners} times as "
            "an absolute value does: record it with its sign, or name the signal that has it with --effort; if it is "
            "right as it is, say --effort-kind motor."
        )


def work_share(velocity: Floats, effort: Floats) -> float:
    """Work of an effort (n,) on a joint of this velocity (n,), as a share of all that it does and takes back.

    Of what changes only: a weight that sinks slowly takes no part. Friction makes it positive: 1 where the effort only
    drives the joint, 0 where nothing is lost, negative where the effort has lost its sign.
    """
    power = (velocity - np.mean(velocity)) * (effort - np.mean(effort))
    return float(np.sum(power)) / max(float(np.sum(np.abs(power))), 1e-300)


def brakes(recording: Recording) -> bool:
    """Whether the effort of the recording takes up far more work than it does, as one of the opposite sign does."""
    return work_share(np.gradient(recording.motor_position), recording.motor_torque) < BRAKES


def corners_at_zero(effort: Floats) -> int:
    """How often an effort (n,) that keeps to one side meets zero with a corner; 0 where that is not what it does.

    At a corner both sides are straight and fall and rise alike: the slope breaks. At a smooth minimum it passes through
    zero, and after a jump of dry friction one side only is steep.
    """
    largest = float(np.max(np.abs(effort), initial=0.0))
    x = effort if float(np.sum(effort)) >= 0.0 else -effort
    if effort.size < 100 or largest == 0.0 or float(np.min(x)) < -OTHER_SIDE * largest:
        return 0
    noise = _noise(x)
    if noise > NEAR_ZERO * largest:
        return 0
    shapes = [s for k in _minima(x, NEAR_ZERO * largest) if (s := _shape(x, int(k), noise)) is not None]
    corners = sum(shapes)
    return corners if shapes and corners >= CORNERS * len(shapes) else 0


def _noise(x: Floats) -> float:
    """Standard deviation of what third differences say is noise: a low quantile, so that jumps do not count."""
    third = np.abs(np.diff(x, 3))
    return float(np.quantile(third, 0.3)) / 0.385 / math.sqrt(20.0)


def _minima(x: Floats, level: float) -> NDArray[np.int64]:
    """Where the effort is least within each visit below `level`."""
    labels, count = ndimage.label(x < level)
    if not count:
        return np.zeros(0, np.int64)
    where = ndimage.minimum_position(x, labels, np.arange(1, count + 1))
    return np.array([w[0] for w in where], dtype=np.int64)


def _shape(x: Floats, k: int, noise: float) -> bool | None:
    """Whether the minimum at sample `k` is a corner; None where it cannot be seen."""
    for leg in LEGS:
        if k - 2 * leg - 1 < 0 or k + 2 * leg + 1 >= x.size:
            return None
        # The vertex lies between samples: the two sides are each taken from the sample next to the least one.
        left, right = x[[k - 1, k - 1 - leg, k - 1 - 2 * leg]], x[[k + 1, k + 1 + leg, k + 1 + 2 * leg]]
        fall, rise = float(left[1] - left[0]), float(right[1] - right[0])
        if min(fall, rise) < RISEN * noise:
            continue
        slope_left, slope_right = fall / leg, rise / leg
        # Both sides prolonged meet at zero, between the samples around the minimum; those of a parabola meet below it.
        where = (float(left[0]) - slope_left - float(right[0]) + slope_right) / (slope_left + slope_right)
        meet = float(left[0]) - slope_left * (1.0 + where)
        if abs(where) > 1.0 + MEETING or abs(meet) > MEETING * min(slope_left, slope_right) + RISEN * noise:
            return False
        bend = max(abs(left[2] - 2.0 * left[1] + left[0]), abs(right[2] - 2.0 * right[1] + right[0]))
        return bool(bend < STRAIGHT * (fall + rise) * 0.5 + RISEN * noise and min(fall, rise) > 0.3 * max(fall, rise))
    return None
