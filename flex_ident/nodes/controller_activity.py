"""What controller managers publish of their controllers in the diagnostics."""

from __future__ import annotations

import time
from collections.abc import Iterable

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from flex_ident.excitation.activity import Activity
from flex_ident.recording.names import harmless

TOPIC = "/diagnostics"


class ControllerActivity:
    """Hears the diagnostics of all robots around."""

    def __init__(self, node: Node) -> None:
        self._activity = Activity()
        node.create_subscription(DiagnosticArray, TOPIC, self._on_message, 10)

    def _on_message(self, message: DiagnosticArray) -> None:
        now = time.monotonic()
        for status in message.status:
            self._activity.hear(now, status.name, {v.key: harmless(v.value) for v in status.values})

    def objection(self, controllers: Iterable[str]) -> str:
        """Which of the controllers is not active; empty when none is known not to be."""
        return self._activity.objection(time.monotonic(), controllers)
