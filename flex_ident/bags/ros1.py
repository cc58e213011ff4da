"""ROS 1 bags, through rosbags."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rosbags.rosbag1 import Reader, ReaderError

from flex_ident.bags.messages import Block, Topic, block_of
from flex_ident.errors import BagError
from flex_ident.recording import Notice

MAGIC = b"#ROSBAG V2.0\n"
ROWS = 20_000


class Ros1File:
    """One .bag file. Raises BagError when rosbags cannot open it (an unindexed bag: run `rosbag reindex`)."""

    ros1 = True

    def __init__(self, path: Path) -> None:
        self.path = path
        self._notices: list[Notice] = []
        try:
            self._reader = Reader(path)
            self._reader.open()
        except (ReaderError, OSError, ValueError, AssertionError, KeyError) as error:
            raise BagError(f"{path}: cannot be read as a ROS 1 bag ({error}); try 'rosbag reindex'.") from error

    def topics(self) -> tuple[Topic, ...]:
        """The topics of the bag."""
        return tuple(Topic(c.topic, c.msgtype, c.msgdef.data, "msg") for c in self._reader.connections)

    def notices(self) -> tuple[Notice, ...]:
        """What was lost to damage."""
        return tuple(self._notices)

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics in blocks."""
        connections = [c for c in self._reader.connections if c.topic in wanted]
        if not connections:
            return
        pending: dict[str, tuple[list[int], list[bytes]]] = {}
        read = 0
        try:
            for connection, received, data in self._reader.messages(connections):
                times, payloads = pending.setdefault(connection.topic, ([], []))
                times.append(received)
                payloads.append(bytes(data))
                read += 1
                if len(times) >= ROWS:
                    yield block_of(connection.topic, times, payloads)
                    del pending[connection.topic]
        except (ReaderError, ValueError, AssertionError) as error:
            text = f"{self.path.name} is damaged ({error}): {read} messages were read, the rest is lost."
            self._notices.append(Notice("bag_damaged", text))
        for topic, (times, payloads) in pending.items():
            yield block_of(topic, times, payloads)
