"""Commands as messages, for the joints of a controller in its order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Duration
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = "command.joints"


class CommandMessages:
    """Messages of one kind, `forward_command` or `joint_trajectory`."""

    def __init__(self, kind: str, joints: Sequence[str], period_s: float) -> None:
        self.message_class = JointTrajectory if kind == "joint_trajectory" else Float64MultiArray
        self.joints = tuple(joints)
        seconds = int(period_s)
        self._period = Duration(sec=seconds, nanosec=round((period_s - seconds) * 1e9))

    def row(self, joint: str, command: float, others: Sequence[float]) -> tuple[float, ...]:
        """The command of one joint among those of the others, in the controller's order."""
        at = self.joints.index(joint)
        return (*others[:at], command, *others[at:])

    def message(self, row: Sequence[float]) -> Any:
        """A row of numbers as a message."""
        if self.message_class is Float64MultiArray:
            return Float64MultiArray(data=list(row))
        # Without a velocity, which a controller refuses in a trajectory's last point.
        point = JointTrajectoryPoint(positions=list(row), time_from_start=self._period)
        return JointTrajectory(joint_names=list(self.joints), points=[point])


def command_messages(values: dict[str, Any]) -> CommandMessages:
    """The messages that the exciter's parameters ask for."""
    joints = values[JOINTS] or [values["joint"]]
    return CommandMessages(values["command.type"], joints, 1.0 / values["rate_hz"])
