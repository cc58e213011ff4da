"""Hands commands on, as a controller would that leaves when it is told to: `python relay.py ORIGIN GOAL LISTENERS`.

A process of its own: in the node of the rig, which also listens to everything, a command might wait for its turn.
"""

from __future__ import annotations

import sys
import time
from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float64MultiArray

MATCHED_S = 0.5
"""A publisher that has found a listener may not have been found by it: what it sends until then is lost."""


def main(origin: str, goal: str, listeners: int) -> None:
    """Listen to `origin` once that many listen to `goal`, so that the exciter waits for both."""
    rclpy.init()
    node = rclpy.create_node("relay")
    publisher = node.create_publisher(Float64MultiArray, goal, 10)
    while publisher.get_subscription_count() < listeners:
        time.sleep(0.05)
    time.sleep(MATCHED_S)
    node.create_subscription(Float64MultiArray, origin, publisher.publish, 10)
    rclpy.spin(node)


if __name__ == "__main__":
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
