"""A joint trajectory as a command over time."""

from __future__ import annotations

import math

from trajectory_msgs.msg import JointTrajectory


class TrajectoryCommand:
    """Positions of one joint of a message, interpolated from the command at its arrival, `start` s."""

    def __init__(self, message: JointTrajectory, joint: str, start: float, position: float) -> None:
        index = list(message.joint_names).index(joint)
        self._points = [(start, position)]
        for point in message.points:
            time = start + point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec
            if len(point.positions) > index and math.isfinite(point.positions[index]):
                self._points.append((max(time, self._points[-1][0]), point.positions[index]))

    def at(self, time: float) -> float:
        """The commanded position at `time` s."""
        for (t0, p0), (t1, p1) in zip(self._points, self._points[1:], strict=False):
            if time < t1:
                return p0 + (p1 - p0) * (time - t0) / (t1 - t0) if t1 > t0 else p1
        return self._points[-1][1]
