"""What goes over the wire: joint states read into samples, commands and reference written."""

from __future__ import annotations

import math
from typing import Any

from builtin_interfaces.msg import Duration
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from flex_ident.excitation import JointSample, Output

JOINT_STATE = "sensor_msgs/msg/JointState"


def joint_sample(data: bytes, joint: str, held: tuple[str, ...], received: float) -> JointSample:
    """A joint state's bytes as the exciter takes them; `received` is the steady clock's time, s."""
    message = deserialize_message(data, JointState)
    stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec or received
    names = list(message.name)

    def of(values: Any, name: str) -> float:
        i = names.index(name) if name in names else len(values)
        return float(values[i]) if i < len(values) else math.nan

    if joint not in names:
        return JointSample(received, stamp, None, names=tuple(names))
    return JointSample(
        received, stamp, of(message.position, joint), of(message.velocity, joint), of(message.effort, joint),
        tuple(of(message.position, j) for j in held), tuple(of(message.velocity, j) for j in held),
        tuple(of(message.effort, j) for j in held), tuple(names),
    )  # fmt: skip


class CommandMessages:
    """Messages of one kind for the joints of a controller, in its order."""

    def __init__(self, kind: str, joints: list[str], joint: str, period_s: float) -> None:
        self.message_class = JointTrajectory if kind == "joint_trajectory" else Float64MultiArray
        self._joints = joints
        self._at = joints.index(joint)
        seconds = int(period_s)
        self._period = Duration(sec=seconds, nanosec=round((period_s - seconds) * 1e9))

    def message(self, output: Output) -> Any:
        """The command as a message; None when there is none to send."""
        if output.command is None:
            return None
        row = [*output.others[: self._at], output.command, *output.others[self._at :]]
        if self.message_class is Float64MultiArray:
            return Float64MultiArray(data=row)
        # Without a velocity, which a controller refuses in a trajectory's last point.
        point = JointTrajectoryPoint(positions=row, time_from_start=self._period)
        return JointTrajectory(joint_names=self._joints, points=[point])


def reference_bytes(joint: str, output: Output, stamp_ns: int) -> bytes:
    """The reference as a serialised JointState."""
    message = JointState(name=[joint], position=[output.position], velocity=[output.velocity])
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 1_000_000_000)
    return bytes(serialize_message(message))
