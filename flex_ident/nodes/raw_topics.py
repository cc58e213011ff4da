"""Raw subscriptions, emptied by a thread of their own, which counts by DDS's numbers what got lost.

No executor serves them: rclpy's events executor can lock up inside rmw_fastrtps when it is told of lost messages
(rmw_fastrtps, pull request 890), and takes no messages with their numbers; the other one is slow with many topics.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from flex_ident.excitation.pace import Losses
from flex_ident.nodes.command_clock import AROUND, real_time
from flex_ident.nodes.message_types import message_class

DEPTH = 2000
STOP_S = 5.0
"""How long the thread may take to end: it must not touch what is taken down after it."""
TAKE_S = 1e-3
"""How often messages are taken."""
AT_ONCE = 50
"""Messages of one topic that are taken before those that are urgent are looked at again."""
Received = Callable[[bytes], None]


class Polled(CallbackGroup):
    """Subscriptions that no executor serves: the thread that needs the messages takes them itself."""

    def can_execute(self, entity: Any) -> bool:
        """Never."""
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """Never."""
        return False

    def ending_execution(self, entity: Any) -> None:
        """Nothing to do."""


@dataclass
class _Topic:
    """A subscription, as its publishers offer it."""

    message_type: str
    received: Received
    qos: QoSProfile
    made: Any
    publishers: int
    urgent: bool
    losses: Losses = field(default_factory=Losses)


class RawTopics:
    """Hands the bytes of each message on, in one thread for all topics."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._group = Polled()
        self._topics: dict[str, _Topic] = {}
        self._lost_before = 0
        self._error: Exception | None = None
        self._lock = threading.RLock()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="topics", daemon=True)
        self._thread.start()

    @property
    def lost(self) -> int:
        """Messages that were sent and never came."""
        with self._lock:
            return self._lost_before + sum(t.losses.lost for t in self._topics.values())

    def subscribe(self, topic: str, received: Received, *, urgent: bool = False) -> str:
        """Subscribe once somebody publishes, anew when that is offered otherwise; the topic's type, empty before.

        What is `urgent` waits for no other topic, however many messages of those have come. Raises UsageError for
        unknown types.
        """
        offers = self._node.get_publishers_info_by_topic(topic)
        before = self._topics.get(topic)
        if not offers:
            return before.message_type if before else ""
        message_type = str(offers[0].topic_type)
        qos = _offered(offers)
        if before is not None:
            before.publishers = len(offers)
            same = message_type == before.message_type
            if not same or (before.qos.reliability, before.qos.durability) == (qos.reliability, qos.durability):
                return before.message_type
            self.end(topic)
        kind = message_class(message_type)
        made = self._node.create_subscription(kind, topic, lambda _: None, qos, raw=True, callback_group=self._group)
        with self._lock:
            self._topics[topic] = _Topic(message_type, received, qos, made, len(offers), urgent)
        return message_type

    def follow(self) -> None:
        """Subscribe anew where a publisher has come back that offers its topic otherwise.

        Raises what went wrong with a message.
        """
        if self._error is not None:
            raise self._error
        for topic, made in list(self._topics.items()):
            self.subscribe(topic, made.received, urgent=made.urgent)

    def end(self, topic: str) -> None:
        """Unsubscribe."""
        with self._lock:
            ended = self._topics.pop(topic, None)
            if ended is not None:
                self._lost_before += ended.losses.lost
                self._node.destroy_subscription(ended.made)

    def stop(self) -> None:
        """Take no more messages."""
        self._stopping.set()
        self._thread.join(STOP_S)

    def _run(self) -> None:
        real_time(AROUND)  # a robot waits for what it hears here
        try:
            self._take_on()
        except Exception as error:  # raised where it is seen
            self._error = error

    def _take_on(self) -> None:
        more = False
        while not self._stopping.wait(0.0 if more else TAKE_S):
            more, since = False, AT_ONCE
            for name, topic in list(self._topics.items()):
                if since >= AT_ONCE:
                    self._hand_on_urgent()
                    since = 0
                if not topic.urgent:
                    count = self._hand_on(name)
                    more |= count == AT_ONCE
                    since += count

    def _hand_on_urgent(self) -> None:
        for name, topic in list(self._topics.items()):
            if topic.urgent:
                while self._hand_on(name) == AT_ONCE:
                    pass

    def _hand_on(self, name: str) -> int:
        """Hand on what has arrived on a topic, AT_ONCE messages at most; how many there were."""
        with self._lock:
            topic = self._topics.get(name)
            taken = [] if topic is None else self._taken(topic)
        if topic is not None:
            for data in taken:
                topic.received(data)
        return len(taken)

    def _taken(self, topic: _Topic) -> list[bytes]:
        """What has arrived, AT_ONCE messages at most."""
        messages: list[bytes] = []
        with topic.made.handle:
            while len(messages) < AT_ONCE:
                taken = topic.made.handle.take_message(topic.made.msg_type, True)
                if taken is None:
                    break
                data, info = taken
                messages.append(data)
                number = info.get("publication_sequence_number")
                if number is not None:
                    topic.losses.count(number, topic.publishers)
        return messages


def _offered(offers: list[Any]) -> QoSProfile:
    """What can be had of all publishers."""
    reliable = all(o.qos_profile.reliability == ReliabilityPolicy.RELIABLE for o in offers)
    latched = all(o.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for o in offers)
    return QoSProfile(
        depth=DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
