"""What the exciter says of itself: `~/state`, latched and when it changes, `/diagnostics`, and a line in the log."""

from __future__ import annotations

import time
from collections.abc import Iterable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from flex_ident.excitation.run import Note
from flex_ident.nodes.running import on_stderr

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
DELIVERED_S = 2.0
"""How long a node that ends waits for those who have yet to take its last state: a reader that lost it asks again only
every some hundred milliseconds, and one that hangs must not keep the node."""
LEVELS = {"aborted": DiagnosticStatus.ERROR, "ramping_down": DiagnosticStatus.WARN}


class StateReports:
    """Publishes a node's state."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._state = node.create_publisher(DiagnosticStatus, "~/state", LATCHED)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._published: tuple[str, str, int] | None = None

    def say(self, notes: Iterable[Note]) -> None:
        """What is to be said, in the log or on standard error."""
        log = self._node.get_logger()
        for level, said in notes:
            text = said.replace("~/", f"{self._node.get_fully_qualified_name()}/")
            match level:  # rclpy refuses one line of code that logs at two levels
                case "stderr":
                    on_stderr(f"{self._node.get_name()}: {said}")
                case "error":
                    log.error(text)
                case "warning":
                    log.warning(text)
                case _:
                    log.info(text)

    def publish(self, joint: str, state: str, reason: str, progress: float, bag: str) -> None:
        """Say the state; `reason` is empty when there is none, `progress` a share, `bag` a path or empty."""
        percent = int(100 * progress)
        name = f"{self._node.get_fully_qualified_name().lstrip('/')}: {joint}"
        status = DiagnosticStatus(
            level=LEVELS.get(state, DiagnosticStatus.OK), name=name,
            message=f"{state}: {reason}" if reason else state, hardware_id=joint,
            values=[
                KeyValue(key="state", value=state), KeyValue(key="reason", value=reason),
                KeyValue(key="progress_percent", value=f"{percent}"), KeyValue(key="bag", value=bag),
            ],
        )  # fmt: skip
        mark = (state, reason, percent)
        if mark != self._published:
            if self._published is not None and self._published[0] != state:
                self._node.get_logger().info(state.replace("_", " ") + (f": {reason}" if reason else ""))
            self._published = mark
            self._state.publish(status)
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._diagnostics.publish(array)

    def delivered(self) -> bool:
        """Wait until everybody who listens has the last state; False when somebody has not taken it in time."""
        ends = time.monotonic() + DELIVERED_S
        return all(
            publisher.wait_for_all_acked(Duration(seconds=max(ends - time.monotonic(), 0.0)))
            for publisher in (self._state, self._diagnostics)
        )
