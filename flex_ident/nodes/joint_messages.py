"""The reference as it goes over the wire."""

from __future__ import annotations

import struct

import numpy as np
from rosbags.typesys import Stores, get_typestore

from flex_ident.excitation import Output

JOINT_STATE = "sensor_msgs/msg/JointState"
STORE = get_typestore(Stores.ROS2_JAZZY)


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
