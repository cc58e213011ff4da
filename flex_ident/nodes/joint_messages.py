"""What goes over the wire: joint states read into samples, the reference written."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState

from flex_ident.excitation import JointSample, Output

JOINT_STATE = "sensor_msgs/msg/JointState"
STORE = get_typestore(Stores.ROS2_JAZZY)


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


class ReferenceMessages:
    """The reference as a serialised JointState of one joint: a constant layout, in which the numbers are set.

    rclpy's serialisation leaves padding after an empty array, which strict readers of bags refuse.
    """

    def __init__(self, joint: str) -> None:
        types, none = STORE.types, np.zeros(0)
        stamp = types["builtin_interfaces/msg/Time"](0, 0)
        message = types[JOINT_STATE](types["std_msgs/msg/Header"](stamp, ""), [joint], np.zeros(1), np.zeros(1), none)
        self._bytes = bytearray(STORE.serialize_cdr(message, JOINT_STATE, little_endian=True))

    def message(self, output: Output, stamp_ns: int) -> bytes:
        """The bytes at one instant of ROS time."""
        end = len(self._bytes)  # ..., position (8), velocity's count and padding (8), velocity (8), effort's count (4)
        struct.pack_into("<iI", self._bytes, 4, *divmod(stamp_ns, 1_000_000_000))
        struct.pack_into("<d", self._bytes, end - 28, output.position)
        struct.pack_into("<d", self._bytes, end - 12, output.velocity)
        return bytes(self._bytes)
