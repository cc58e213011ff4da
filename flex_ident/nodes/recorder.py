"""Further topics recorded byte for byte, and what the node writes itself, into one bag."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.node import Node

from flex_ident.errors import UsageError
from flex_ident.excitation.pace import Pace, Stillness
from flex_ident.nodes.bag_file import MIB, BagFile, unique_folder
from flex_ident.nodes.message_types import definition_and_digest, without_stamp
from flex_ident.nodes.raw_topics import RawTopics
from flex_ident.recording.names import at_home

LONGEST_COMPARED = 65536
"""Length, bytes, of the longest messages that are compared with those before."""


class Recorder:
    """Further topics into a bag, as soon as each is published, and what the node writes itself."""

    def __init__(
        self, node: Node, raw: RawTopics, bag: BagFile, topics: list[str], own: Sequence[str] = ()
    ) -> None:  # fmt: skip
        """`topics` are recorded as they come, those of `own` are written by the node itself."""
        self.bag = bag
        self._node = node
        self._raw = raw
        self._lost_before = raw.lost
        self._wanted = list(dict.fromkeys(t for t in map(node.resolve_topic_name, topics) if t not in own))
        self._paces: dict[str, Pace] = {topic: Pace(topic, time.monotonic()) for topic in own}
        self._received: list[str] = []
        self._types: dict[str, str] = {}
        self._stillness: dict[str, Stillness] = {}
        self._latest: dict[str, bytes] = {}
        """A message of each further topic that has come since these were looked at."""
        self._refused: dict[str, str] = {}

    @property
    def lost(self) -> int:
        """Messages lost by DDS or to a slow disk."""
        return self._raw.lost - self._lost_before + self.bag.lost

    @property
    def unpublished(self) -> str:
        """Further topics that are not being received, and why; empty when all are."""
        unheard = dict.fromkeys(self._wanted, "nobody publishes it")
        return ", ".join(f"{topic} ({why})" for topic, why in (self._refused | unheard).items())

    @property
    def silent(self) -> str:
        """Further topics that no message came from, and why; empty when there are none."""
        never = [topic for topic in self._received if not self._paces[topic].count]
        silent = ", ".join(f"{topic} (published, but no message came)" for topic in never)
        return ", ".join(filter(None, (self.unpublished, silent)))

    def announce(self, topic: str, message_type: str) -> None:
        """Prepare a topic that is written by `write`."""
        self.bag.add_topic(topic, message_type, *definition_and_digest(message_type))

    def write(self, topic: str, data: bytes, stamp_ns: int | None = None) -> None:
        """Record a message as of an instant of ROS time, as received now without one."""
        self._paces[topic].arrived(time.monotonic())
        self.bag.write(topic, self._node.get_clock().now().nanoseconds if stamp_ns is None else stamp_ns, data)

    def _take(self, topic: str, data: bytes) -> None:
        self._latest[topic] = data
        self.write(topic, data)

    def find_topics(self) -> None:
        """Subscribe to what has appeared of the topics wanted."""
        for topic in list(self._wanted):
            offers = self._node.get_publishers_info_by_topic(topic)
            if not offers:
                continue
            self._wanted.remove(topic)
            try:
                self.announce(topic, str(offers[0].topic_type))
                self._paces[topic] = Pace(topic, time.monotonic())
                self._types[topic], self._stillness[topic] = str(offers[0].topic_type), Stillness(topic)
                self._raw.subscribe(topic, partial(self._take, topic))
                self._received.append(topic)
            except UsageError as error:
                self._refused[topic] = str(error).rstrip(".")
                self._node.get_logger().warning(f"{topic} is not recorded: {error}")

    def changes(self) -> list[str]:
        """What has changed in the pace of the topics since the last call, and which have frozen."""
        now = time.monotonic()
        said = [pace.look(now) for pace in list(self._paces.values())]
        for topic in list(self._latest):
            data = self._latest.pop(topic)
            if len(data) <= LONGEST_COMPARED:
                said.append(self._stillness[topic].look(now, without_stamp(self._types[topic], data)))
        return [text for text in said if text]

    def paces(self) -> str:
        """How many messages of each topic came, how fast, with the longest gap."""
        return "; ".join(pace.summary() for pace in self._paces.values())

    def close(self) -> None:
        """End the recording; the bag is complete then."""
        for topic in self._received:
            self._raw.end(topic)
        self.bag.close()


def opened_recorder(
    node: Node, raw: RawTopics, directory: Path, values: Mapping[str, Any], information: dict[str, str],
    topics: list[str], own: Sequence[str],
) -> Recorder:  # fmt: skip
    """A recorder into a new bag in a directory, named after the joint and the time. Raises FlexIdentError."""
    stem = f"{values['joint']}_{time.strftime('%Y%m%d_%H%M%S')}".replace("/", "_")
    bag = BagFile(
        unique_folder(at_home(directory).resolve(), stem), storage=str(values["recording.storage"]),
        information=information, least_free=int(values["recording.least_free_mib"] * MIB),
    )  # fmt: skip
    return Recorder(node, raw, bag, topics, own)
