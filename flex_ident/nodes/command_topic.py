"""The topic that the controller takes commands from: who listens, and who else publishes there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rclpy.node import Node


class CommandTopic:
    """A publisher of commands; `allies` are nodes, by full name, that may publish there as well."""

    def __init__(self, node: Node, message_class: Any, topic: str, allies: Sequence[str] = ()) -> None:
        self._node = node
        self._publisher = node.create_publisher(message_class, topic, 10)
        self.name = str(self._publisher.topic_name)
        self._allies = allies

    def publish(self, message: Any) -> None:
        """Send a command."""
        self._publisher.publish(message)

    def listeners(self) -> int:
        """How many take the commands."""
        return int(self._publisher.get_subscription_count())

    def others(self) -> str:
        """Names of other nodes that may command the robot; empty when there are none."""
        if self._node.count_publishers(self.name) < 2:
            return ""
        ours = [full_name(self._node.get_name(), self._node.get_namespace()), *self._allies]
        found = []
        for info in self._node.get_publishers_info_by_topic(self.name):
            name = full_name(info.node_name, info.node_namespace)
            if name in ours:
                ours.remove(name)  # a second node of the same name is another one
            else:
                found.append(name.lstrip("/") if info.node_namespace == self._node.get_namespace() else name)
        return ", ".join(sorted(set(found)))


def full_name(name: str, namespace: str) -> str:
    """A node's name with its namespace."""
    return f"{namespace.rstrip('/')}/{name}"
