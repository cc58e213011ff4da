"""Publishes many topics fast, as a process of its own: `python many_topics.py TOPICS RATE_HZ`."""

from __future__ import annotations

import os
import sys
import time
from contextlib import suppress

import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from std_msgs.msg import String

PRIORITY = 5
"""Below that of the exciter."""


def main() -> None:
    """Publish until the process is ended."""
    topics, rate_hz = int(sys.argv[1]), float(sys.argv[2])
    with suppress(OSError, AttributeError):  # drivers elsewhere do not wait for this computer's processors
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    rclpy.init()
    node = rclpy.create_node("many")
    quality = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    publishers = [node.create_publisher(String, f"/many_{k}", quality) for k in range(topics)]
    begin, sent = time.monotonic(), 0
    while rclpy.ok():
        message = serialize_message(String(data=f"{sent:010d}"))  # once for all: thirty times cost the rate
        for publisher in publishers:
            publisher.publish(message)
        sent += 1
        time.sleep(max(0.0, begin + sent / rate_hz - time.monotonic()))


if __name__ == "__main__":
    main()
