"""Topics recorded byte for byte: raw subscriptions in front of a bag."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks, UnsupportedEventTypeError
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from flex_ident.errors import UsageError
from flex_ident.nodes.bag_file import MIB, BagFile, unique_folder
from flex_ident.nodes.message_types import definition_and_digest, message_class

DEPTH = 2000
Received = Callable[[bytes], None]


class RawTopics:
    """Raw subscriptions that count what DDS lost; each hands its bytes on."""

    def __init__(self, node: Node) -> None:
        self.lost = 0
        self._node = node
        self._made: dict[str, Any] = {}

    def subscribe(self, topic: str, received: Received) -> str:
        """Subscribe once somebody publishes; the topic's type then, else empty. Raises UsageError for unknown types."""
        offers = self._node.get_publishers_info_by_topic(topic)
        if not offers:
            return ""
        message_type = str(offers[0].topic_type)
        if topic in self._made:
            return message_type
        kind = message_class(message_type)
        reliable = all(o.qos_profile.reliability == ReliabilityPolicy.RELIABLE for o in offers)
        latched = all(o.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for o in offers)
        qos = QoSProfile(
            depth=DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        try:
            events = SubscriptionEventCallbacks(message_lost=self._on_lost)
            made = self._node.create_subscription(kind, topic, received, qos, raw=True, event_callbacks=events)
        except UnsupportedEventTypeError:
            made = self._node.create_subscription(kind, topic, received, qos, raw=True)
        self._made[topic] = made
        return message_type

    def end(self, topic: str) -> None:
        """Unsubscribe."""
        made = self._made.pop(topic, None)
        if made is not None:
            self._node.destroy_subscription(made)

    def _on_lost(self, event: Any) -> None:
        self.lost += int(event.total_count_change)


class Recorder:
    """Further topics into a bag, as soon as each is published, and what the node writes itself."""

    def __init__(self, node: Node, bag: BagFile, topics: list[str], own: Sequence[str] = ()) -> None:
        """`topics` are recorded as they come, those of `own` are written by the node itself."""
        self.bag = bag
        self._node = node
        self._raw = RawTopics(node)
        self._wanted = list(dict.fromkeys(t for t in map(node.resolve_topic_name, topics) if t not in own))
        self._received: dict[str, int] = {}
        self._refused: dict[str, str] = {}

    @property
    def lost(self) -> int:
        """Messages lost by DDS or to a slow disk."""
        return self._raw.lost + self.bag.lost

    @property
    def unpublished(self) -> str:
        """Further topics that are not being received, and why; empty when all are."""
        unheard = dict.fromkeys(self._wanted, "nobody publishes it")
        return ", ".join(f"{topic} ({why})" for topic, why in (self._refused | unheard).items())

    @property
    def silent(self) -> str:
        """Further topics that no message came from, and why; empty when there are none."""
        silent = ", ".join(f"{topic} (published, but no message came)" for topic, n in self._received.items() if not n)
        return ", ".join(filter(None, (self.unpublished, silent)))

    def announce(self, topic: str, message_type: str) -> None:
        """Prepare a topic that is written by `write`."""
        self.bag.add_topic(topic, message_type, *definition_and_digest(message_type))

    def write(self, topic: str, data: bytes) -> None:
        """Record a message as received now."""
        self.bag.write(topic, self._node.get_clock().now().nanoseconds, data)

    def find_topics(self) -> None:
        """Subscribe to what has appeared of the topics wanted."""
        for topic in list(self._wanted):
            try:
                message_type = self._raw.subscribe(topic, partial(self._on_message, topic))
                if not message_type:
                    continue
                self.announce(topic, message_type)
                self._received[topic] = 0
            except UsageError as error:
                self._refused[topic] = str(error).rstrip(".")
                self._node.get_logger().warning(f"{topic} is not recorded: {error}")
            self._wanted.remove(topic)

    def _on_message(self, topic: str, data: bytes) -> None:
        self._received[topic] += 1
        self.write(topic, data)

    def close(self) -> None:
        """End the recording; the bag is complete then."""
        for topic in self._received:
            self._raw.end(topic)
        self.bag.close()


def opened_recorder(
    node: Node, directory: Path, values: Mapping[str, Any], information: dict[str, str], topics: list[str],
    own: Sequence[str],
) -> Recorder:  # fmt: skip
    """A recorder into a new bag in a directory, named after the joint and the time. Raises FlexIdentError."""
    stem = f"{values['joint']}_{time.strftime('%Y%m%d_%H%M%S')}".replace("/", "_")
    bag = BagFile(
        unique_folder(directory.expanduser().resolve(), stem), storage=str(values["recording.storage"]),
        information=information, least_free=int(values["recording.least_free_mib"] * MIB),
    )  # fmt: skip
    return Recorder(node, bag, topics, own)
