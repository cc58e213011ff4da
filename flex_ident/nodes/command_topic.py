"""The topic that the controller takes commands from: who listens, and who else publishes there."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from flex_ident.nodes.command_messages import command_messages
from flex_ident.nodes.guard import Post
from flex_ident.nodes.guarded import GuardProcess


class CommandTopic:
    """A publisher of commands, and a guard that may publish there as well."""

    def __init__(self, node: Node, values: dict[str, Any]) -> None:
        self._node = node
        message_class = command_messages(values).message_class
        self._publisher = node.create_publisher(message_class, str(values["command.topic"]), 10)
        self.name = str(self._publisher.topic_name)
        name, namespace = f"{node.get_name()}_guard", str(node.get_namespace())
        self._own_name, self._guards_name = full_name(node.get_name(), namespace), full_name(name, namespace)
        states = str(node.resolve_topic_name("joint_states"))
        self.guard = GuardProcess(
            Post(name, namespace, self.name, values["command.type"], 1.0 / values["rate_hz"], states)
        )

    def publish(self, message: Any) -> None:
        """Send a command."""
        self._publisher.publish(message)

    def listeners(self) -> int:
        """How many take the commands."""
        return int(self._publisher.get_subscription_count())

    def others(self) -> str:
        """Names of other nodes that may command the robot; empty when there are none."""
        ours = [self._own_name]
        found = []
        for info in self._node.get_publishers_info_by_topic(self.name):
            name = full_name(info.node_name, info.node_namespace)
            if bytes(info.endpoint_gid).hex() == self.guard.mark or name == self._guards_name:
                continue
            if name in ours:
                ours.remove(name)  # a second node of the same name is another one
            else:
                found.append(name.lstrip("/") if info.node_namespace == self._node.get_namespace() else name)
        return ", ".join(sorted(set(found)))


def publishers(node: Node, topic: str) -> tuple[str, ...]:
    """Names of the nodes that publish a topic."""
    infos = node.get_publishers_info_by_topic(topic)
    return tuple(sorted(full_name(info.node_name, info.node_namespace) for info in infos))


def full_name(name: str, namespace: str) -> str:
    """A node's name with its namespace."""
    return f"{namespace.rstrip('/')}/{name}"
