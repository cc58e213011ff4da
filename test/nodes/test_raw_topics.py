"""What a robot is watched by waits for nothing that is only recorded."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
import rclpy
from rclpy.publisher import Publisher
from rig import Rig, rig
from std_msgs.msg import String

from flex_ident.nodes.raw_topics import DEPTH, RawTopics

pytestmark = pytest.mark.ros
BACKLOG, EACH_S = 500, 2e-3


def subscribed(made: Rig, raw: RawTopics, topic: str, taken: list[float], each_s: float, *, urgent: bool) -> Publisher:
    """A publisher of a topic, once what it says is received; each message takes so long."""

    def received(_: bytes) -> None:
        taken.append(time.monotonic())
        time.sleep(each_s)

    publisher = made.node.create_publisher(String, topic, DEPTH)
    until = time.monotonic() + 15.0
    while not raw.subscribe(topic, received, urgent=urgent):
        assert time.monotonic() < until
        made.spin(0.05)
    made.met(publisher)
    return publisher


def test_what_is_urgent_does_not_wait_behind_others(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        node = rclpy.create_node("listener")  # the rig's events executor would take its messages
        raw = RawTopics(node)
        others: list[float] = []
        urgent: list[float] = []
        bulk = subscribed(made, raw, "/bulk", others, EACH_S, urgent=False)
        states = subscribed(made, raw, "/states", urgent, 0.0, urgent=True)
        with raw._lock:  # nothing is taken meanwhile
            for _ in range(BACKLOG):
                bulk.publish(String(data="x"))
            made.spin(0.3)
        ends = time.monotonic() + BACKLOG * EACH_S
        while time.monotonic() < ends:
            states.publish(String(data="y"))
            time.sleep(0.01)
        while len(others) < BACKLOG and time.monotonic() < ends + 10.0:
            time.sleep(0.1)
        raw.stop()
        node.destroy_node()
    assert len(others) == BACKLOG
    assert np.max(np.diff(urgent)) < 0.4 * BACKLOG * EACH_S
    assert len([t for t in urgent if t < others[-1]]) > 3
