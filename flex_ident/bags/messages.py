"""What every kind of bag looks like from outside: topics, and blocks of raw messages in the order of the file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from flex_ident.notices import Notice

ROWS = 4096
"""Messages in a block, at most."""


@dataclass(frozen=True)
class Topic:
    """One topic: its message type (`sensor_msgs/msg/JointState`) and the definition embedded in the bag, if any.

    `encoding` is cdr, ros1, json or protobuf; `schema` and `schema_name` are as the file has them where
    messages are not serialised as ROS does.
    """

    name: str
    message_type: str
    definition: str = ""
    definition_format: str = "msg"
    count: int | None = None
    """Messages that the bag says it holds, where it does."""
    encoding: str = "cdr"
    schema: bytes = b""
    schema_name: str = ""
    given: bool = False
    """Whether the definition is the user's, and so more to be believed than any other."""


@dataclass(frozen=True)
class Block:
    """Messages of one topic: receive times (k,), ns; payload i is `buffer[starts[i] : starts[i] + lengths[i]]`."""

    topic: str
    received: NDArray[np.int64]
    buffer: NDArray[np.uint8]
    starts: NDArray[np.int64]
    lengths: NDArray[np.int64]

    def payload(self, i: int) -> bytes:
        """The bytes of message i."""
        return self.buffer[self.starts[i] : self.starts[i] + self.lengths[i]].tobytes()


class Storage(Protocol):
    """An opened bag file."""

    ros1: bool

    def topics(self) -> tuple[Topic, ...]:
        """The topics that the file holds."""
        ...

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """The messages of the wanted topics, in blocks of bounded size; those of one topic in the file's order."""
        ...

    def announced(self) -> dict[str, int]:
        """Messages of each topic by the file's own indexes, as far as it has any; complete after `blocks`."""
        ...

    def notices(self) -> tuple[Notice, ...]:
        """What could not be read, complete only after `blocks` ran to its end."""
        ...

    def close(self) -> None:
        """Let go of the file."""
        ...


def block_of(topic: str, received: Sequence[int] | NDArray[np.int64], payloads: Sequence[bytes]) -> Block:
    """One block from single messages."""
    lengths = np.fromiter(map(len, payloads), np.int64, len(payloads))
    starts = np.concatenate((np.zeros(1, np.int64), np.cumsum(lengths)))[:-1]
    return Block(topic, np.array(received, np.int64), np.frombuffer(b"".join(payloads), np.uint8), starts, lengths)
