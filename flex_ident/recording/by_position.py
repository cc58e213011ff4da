"""Efforts that follow the position alone: a controller's model of gravity, while a hand moves the joint.

Whatever drives a joint fights its friction, whose sign is that of the speed. An effort that does not know which way the
joint moves is not what moves it.
"""

from __future__ import annotations

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.recording.recording import Floats, Recording

BLOCK_S, FEWEST = 0.04, 50
"""Time over which readings are averaged, and moving stretches of it that are needed."""
RESTS = 0.02
"""Share of the highest speed below which a joint rests."""
FOLLOWS = 0.1
"""Share of the effort's scatter, rms, that the position alone leaves at most."""
OF_MOTION = 0.01
"""The same of what speed and acceleration explain: 0.002 at most in thirteen recordings of an adversary's joints that
were moved by hand, 0.19 at least where a motor moved them slowly."""


def refuse_by_position(recording: Recording) -> None:
    """Raises ExcitationError where the effort follows the position alone."""
    left = left_by_position(recording.motor_position, recording.motor_torque, recording.sample_rate_hz)
    if left is not None:
        raise ExcitationError(
            f"the effort of joint {recording.joint} follows its position alone, to {100.0 * left:.2g} %, and holds no "
            "friction and no inertia: it was moved by hand or by something else, while a controller's model of gravity "
            "held it. Record it while its own motor moves it, and the effort that the motor gives; if it is that of a "
            "torque sensor behind the gear, say --effort-kind joint_sensor."
        )


def left_by_position(position: Floats, effort: Floats, rate_hz: float) -> float | None:
    """Share of an effort's scatter that its position (n,), rad, leaves; None where the motion tells more of it."""
    n = max(1, round(BLOCK_S * rate_hz))
    count = position.size // n
    if count < 2 * FEWEST:
        return None
    q, u = (x[: count * n].reshape(count, n).mean(axis=1) for x in (position, effort))
    speed = np.gradient(q, n / rate_hz)
    moves = np.abs(speed) > RESTS * np.abs(speed).max()
    size = float(np.std(u[moves])) if moves.sum() >= FEWEST else 0.0
    if size <= 0.0:
        return None
    still = np.column_stack((np.cos(q), np.sin(q), np.ones(count)))[moves]
    moving = np.column_stack((np.sign(speed), speed, np.gradient(speed, n / rate_hz)))[moves]
    left = float(np.std(u[moves] - still @ np.linalg.lstsq(still, u[moves], rcond=None)[0])) / size
    both = np.column_stack((still, moving))
    scale = np.linalg.norm(both, axis=0)
    scale[scale == 0.0] = 1.0
    parts = np.linalg.lstsq(both / scale, u[moves], rcond=1e-9)[0] / scale
    of_motion = (float(np.std(moving[:, :2] @ parts[3:5])), float(np.std(moving[:, 2] * parts[5])))
    return left if left < FOLLOWS and max(of_motion) < OF_MOTION * size else None
