"""Where the numbers stand in serialised messages: a constant layout decodes as one strided array.

The layout (lengths of arrays and texts) is taken from one message by walking its type; a message belongs to it when
all those lengths are the same, and the texts that matter. Messages of another layout get their own: joints in another
order, say. CDR as of ROS 2 (alignment from the end of the 4 bytes of encapsulation) and the serialisation of ROS 1.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype

from flex_ident.bags.definitions import EMPTY, Definitions, versions_of
from flex_ident.bags.message_numbers import Layout, Numbers, Scattered, with_joints
from flex_ident.bags.messages import Block, Topic
from flex_ident.bags.namings import FEW_ALIKE, Namings, UnlikelyTopicError
from flex_ident.errors import SignalError
from flex_ident.recording.names import decoded

ENCAPSULATION = 4
REMEMBERED = 64
PADDING = 8
"""Bytes behind a message from which on it is not the one that was meant."""
FREE_STEPS, STEPS_PER_BYTE = 4096, 4
"""Fields of a message that are walked, at most: so many, and so many for each byte of it."""
FREE_WALKS = 1 << 18
"""Fields of all messages of a topic that are walked, at most: so many, and one for each byte of the bag."""
TEXT = 64
"""Characters of a field's path or text that count as one more field."""
NUMBERS = {
    "bool": "u1", "byte": "u1", "char": "u1", "octet": "u1",
    "int8": "i1", "int16": "i2", "int32": "i4", "int64": "i8",
    "uint8": "u1", "uint16": "u2", "uint32": "u4", "uint64": "u8",
    "float32": "f4", "float64": "f8",
}  # fmt: skip


class _MultipliedError(Exception):
    """A definition has more fields than there can be."""


@dataclass
class _Walk:
    """Walks one payload by its type's definition. Raises _MultipliedError when there are over `most` fields."""

    payload: bytes
    definitions: Definitions
    ros1: bool
    keys: tuple[str, ...]
    most: int
    steps: int = 0
    order: str = "<"
    at: int = 0
    numbers: dict[str, Numbers | Scattered] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    fixed: list[int] = field(default_factory=list)

    def layout(self, message_type: str) -> Layout:
        if not self.ros1:
            if self.payload[:1] != b"\0" or self.payload[1] > 1:
                raise struct.error("not plain CDR")
            self.order = "<" if self.payload[1] else ">"
            self.fixed += (0, 1)
            self.at = ENCAPSULATION
        self.message(message_type, "")
        fixed = np.array(self.fixed, np.intp)
        expected = np.frombuffer(self.payload, np.uint8)[fixed]
        return Layout(len(self.payload), self.numbers, self.texts, fixed, expected)

    def message(self, message_type: str, path: str) -> None:
        empty = True
        for name, description in self.definitions[message_type][1]:
            if name != EMPTY:
                empty = False
                self.field(description, f"{path}.{name}" if path else name)
        if empty and not self.ros1:
            self.at += 1

    def field(self, description: Any, path: str) -> None:
        self.count(1 + len(path) // TEXT)
        kind, detail = description
        if kind == Nodetype.NAME:
            self.message(detail, path)
        elif kind == Nodetype.BASE:
            if detail[0] == "string":
                self.text(path)
            else:
                self.row(detail[0], 1, path)
        else:
            element, count = detail
            if kind == Nodetype.SEQUENCE:
                count = self.length()
            if element[0] == Nodetype.BASE and element[1][0] != "string":
                self.row(element[1][0], count, path)
            else:
                for i in range(count):
                    self.field(element, f"{path}.{i}")

    def count(self, steps: int) -> None:
        self.steps += steps
        if self.steps > self.most:
            raise _MultipliedError

    def align(self, size: int) -> None:
        if not self.ros1:
            self.at += (ENCAPSULATION - self.at) % size

    def length(self) -> int:
        self.align(4)
        (count,) = struct.unpack_from(f"{self.order}I", self.payload, self.at)
        if count > len(self.payload):
            raise struct.error("an array is longer than the message")
        self.fixed += range(self.at, self.at + 4)
        self.at += 4
        return int(count)

    def text(self, path: str) -> None:
        size = self.length()
        raw = self.payload[self.at : self.at + size]
        if len(raw) != size:
            raise struct.error("a text runs over the end")
        is_key = path.partition(".")[0] in self.keys
        self.count(size if is_key else size // TEXT)
        self.texts[path] = decoded(raw.rstrip(b"\0"))
        if is_key:
            self.fixed += range(self.at, self.at + size)
        self.at += size

    def row(self, kind: str, count: int, path: str) -> None:
        if kind not in NUMBERS:
            raise struct.error(f"numbers of type {kind}")
        size = int(NUMBERS[kind][1])
        if count:
            self.align(size)
        if self.at + count * size > len(self.payload):
            raise struct.error("an array runs over the end")
        self.numbers[path] = Numbers(self.at, self.order + NUMBERS[kind], count)
        self.at += count * size


class MessageLayouts:
    """Sorts the messages of one topic by layout; remembers the layouts it has met.

    `keys` are the fields whose texts tell layouts apart; `size` is that of the bag's files, in bytes. Raises
    SignalError when the message type is not known, and where its messages have more fields than there can be.
    """

    def __init__(self, topic: Topic, *, ros1: bool, keys: tuple[str, ...] = (), size: int = 0) -> None:
        self._topic, self._ros1, self._keys = topic, ros1, keys
        self._layouts: list[Layout] = []
        self._left = FREE_WALKS + size
        """Fields that may still be walked."""
        self.versions, self._certain = versions_of(topic, ros1=ros1)
        """Fields of each message type, as rosbags describes them; several where the bag says nothing."""
        self.damaged = 0
        """Messages that could not be decoded."""
        self.named = Namings(topic.name)
        """Messages of joint states by the names in them."""

    def tell_apart(self, key: str) -> None:
        """Tell layouts apart by the texts in this field too."""
        self._keys = (*self._keys, key)

    def __call__(self, block: Block) -> Iterator[tuple[Layout, NDArray[np.uint8], NDArray[np.int64]]]:
        """The block's messages, layout by layout: the layout, payloads (k, length), their places (k,) in the block."""
        lengths = block.lengths
        self.damaged += int(np.count_nonzero(lengths <= 0))
        alike = lengths.size > 0 and bool((lengths == lengths[0]).all())
        for length in lengths[:1] if alike else np.unique(lengths):
            if length <= 0:
                continue
            left = np.arange(lengths.size) if alike else np.flatnonzero(lengths == length)
            rows = _rows(block, left, int(length))
            while left.size:
                layout = self._layout(rows[0])
                if layout is None:
                    self.damaged += 1
                    left, rows = left[1:], rows[1:]
                    continue
                fits = layout.fits(rows)
                self.named.count(layout.names, int(np.count_nonzero(fits)))
                if fits.all():
                    yield layout, rows, left
                    break
                yield layout, rows[fits], left[fits]
                left, rows = left[~fits], rows[~fits]

    def _layout(self, row: NDArray[np.uint8]) -> Layout | None:
        for layout in self._layouts:
            if layout.length == row.size and bool((row[layout.fixed] == layout.expected).all()):
                return layout
        for definitions in self.versions:
            own = FREE_STEPS + STEPS_PER_BYTE * row.size
            walk = _Walk(row.tobytes(), definitions, self._ros1, self._keys, min(own, self._left))
            try:
                layout = with_joints(walk.layout(self._topic.message_type), self._topic.message_type)
            except (struct.error, IndexError, KeyError, RecursionError):
                continue
            except _MultipliedError as error:
                raise self._multiplied(row.size, within=own <= self._left) from error
            finally:
                self._left -= walk.steps
            if self._certain or row.size - walk.at < PADDING:
                self.versions = (definitions,)
                self._layouts = [layout, *self._layouts[: REMEMBERED - 1]]
                return layout
        if not self._certain and not self._layouts and self.damaged >= FEW_ALIKE:
            raise SignalError(
                f"{self._topic.name}: no known definition of {self._topic.message_type} fits its messages: name the "
                "robot's own with --type-file X.msg."
            )
        return None

    def _multiplied(self, size: int, *, within: bool) -> UnlikelyTopicError:
        """The error of too many fields, `within` one message or in all of them."""
        what = f"{self._topic.name}: {self._topic.message_type}"
        if within:
            return UnlikelyTopicError(
                f"{what} has more fields than a message of {size} bytes has room for: name a topic of another type."
            )
        return UnlikelyTopicError(f"{what} has messages of which hardly two have the same fields: name another topic.")


def _rows(block: Block, which: NDArray[np.int64], length: int) -> NDArray[np.uint8]:
    """The payloads (k, length) of some messages of equal length, as a view where they stand evenly."""
    starts = block.starts[which]
    steps = np.diff(starts)
    windows = np.lib.stride_tricks.sliding_window_view(block.buffer, length)
    if starts.size > 1 and steps[0] > 0 and bool((steps == steps[0]).all()):
        view: NDArray[np.uint8] = windows[starts[0] : starts[-1] + 1 : int(steps[0])]
        return view
    gathered: NDArray[np.uint8] = windows[starts]
    return gathered


def joint_numbers(layout: Layout, field_name: str, count: int) -> Numbers | Scattered | None:
    """Where `field_name` stands in a JointState of `count` joints; None when the driver left it empty or short."""
    numbers = layout.numbers.get(field_name)
    return numbers if numbers is not None and numbers.count == count and count else None
