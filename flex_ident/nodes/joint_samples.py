"""Joint states as they come over the wire, read into samples; imports little, as the guard must be there soon."""

from __future__ import annotations

import math
from typing import Any

from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from flex_ident.excitation import JointSample


def joint_sample(data: bytes, joint: str, held: tuple[str, ...], received: float, ros_now: float) -> JointSample:
    """A joint state's bytes as the exciter takes them; `received`, s, of the steady clock, is `ros_now` of ROS."""
    message = deserialize_message(data, JointState)
    stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
    age = ros_now - stamp if stamp else math.nan
    stamp = stamp or received
    names = list(message.name)

    def of(values: Any, name: str) -> float:
        i = names.index(name) if name in names else len(values)
        return float(values[i]) if i < len(values) else math.nan

    if joint not in names:
        return JointSample(received, stamp, None, names=tuple(names))
    return JointSample(
        received, stamp, of(message.position, joint), of(message.velocity, joint), of(message.effort, joint),
        tuple(of(message.position, j) for j in held), tuple(of(message.velocity, j) for j in held),
        tuple(of(message.effort, j) for j in held), tuple(names), age,
    )  # fmt: skip
