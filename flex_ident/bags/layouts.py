"""Where the numbers stand in serialised messages: a constant layout decodes as one strided array.

The layout (lengths of arrays and texts) is taken from one message by walking its type; a message belongs to it when
all those lengths are the same, and the texts that matter. Messages of another layout get their own: joints in another
order, say. CDR as of ROS 2 (alignment from the end of the 4 bytes of encapsulation) and the serialisation of ROS 1.
"""

from __future__ import annotations

import re
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from flex_ident.bags.messages import Block, Topic
from flex_ident.errors import SignalError
from flex_ident.recording import Floats
from flex_ident.recording.names import decoded

ENCAPSULATION = 4
REMEMBERED = 64
FEW_ALIKE, RARE = 3, 0.01
"""Messages of the same names, in number and in share of all, up to which they are taken as damaged."""
EMPTY = "structure_needs_at_least_one_member"
"""The byte that stands for a message without fields; ROS 1 does without."""
NUMBERS = {
    "bool": "u1", "byte": "u1", "char": "u1", "octet": "u1",
    "int8": "i1", "int16": "i2", "int32": "i4", "int64": "i8",
    "uint8": "u1", "uint16": "u2", "uint32": "u4", "uint64": "u8",
    "float32": "f4", "float64": "f8",
}  # fmt: skip


@dataclass(frozen=True)
class Numbers:
    """`count` numbers of numpy's type `dtype` in a row at byte `offset`."""

    offset: int
    dtype: str
    count: int

    def of(self, rows: NDArray[np.uint8]) -> Floats:
        """Their values (k, count) in the messages `rows` (k, bytes)."""
        stop = self.offset + self.count * np.dtype(self.dtype).itemsize
        values: Floats = (
            np.ascontiguousarray(rows[:, self.offset : stop]).view(self.dtype).astype(np.float64, copy=False)
        )
        return values


@dataclass(frozen=True)
class Layout:
    """Numbers and texts of one message by their dotted path; `fixed` are the bytes that all its messages share."""

    length: int
    numbers: dict[str, Numbers]
    texts: dict[str, str]
    fixed: NDArray[np.intp]
    expected: NDArray[np.uint8]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Joint names, in order, when it is a JointState's."""
        return tuple(text for path, text in self.texts.items() if path.startswith("name."))

    def fits(self, rows: NDArray[np.uint8]) -> NDArray[np.bool_]:
        """Which (k,) of the messages `rows` (k, length) have this layout."""
        fits: NDArray[np.bool_] = (rows[:, self.fixed] == self.expected).all(axis=1)
        return fits

    def stamps(self, rows: NDArray[np.uint8]) -> NDArray[np.int64]:
        """Header stamps (k,), ns; zero where the message has none."""
        for stamp in ("header.stamp", "stamp"):
            seconds, rest = self.numbers.get(f"{stamp}.sec"), self.numbers.get(f"{stamp}.nanosec")
            if seconds is not None and rest is not None:
                break
        else:
            return np.zeros(rows.shape[0], np.int64)
        whole = seconds.of(rows)[:, 0].astype(np.int64)
        return whole * 1_000_000_000 + rest.of(rows)[:, 0].astype(np.int64)


@dataclass
class _Walk:
    """Walks one payload by its type's definition."""

    payload: bytes
    definitions: Any
    ros1: bool
    keys: tuple[str, ...]
    order: str = "<"
    at: int = 0
    numbers: dict[str, Numbers] = field(default_factory=dict)
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
        fields = [field for field in self.definitions[message_type][1] if field[0] != EMPTY]
        for name, description in fields:
            self.field(description, f"{path}.{name}" if path else name)
        if not fields and not self.ros1:
            self.at += 1

    def field(self, description: Any, path: str) -> None:
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
        self.texts[path] = decoded(raw.rstrip(b"\0"))
        if path.partition(".")[0] in self.keys:
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

    `keys` are the fields whose texts tell layouts apart. Raises SignalError when the message type is not known.
    """

    def __init__(self, topic: Topic, *, ros1: bool, keys: tuple[str, ...] = ()) -> None:
        self._topic, self._ros1, self._keys = topic, ros1, keys
        self._layouts: list[Layout] = []
        self.definitions = _definitions(topic, ros1=ros1)
        """Fields of each message type, as rosbags describes them."""
        self.damaged = 0
        """Messages that could not be decoded."""
        self.named: Counter[tuple[str, ...]] = Counter()
        """Messages of joint states by the names in them."""

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
                self.named[layout.names] += int(np.count_nonzero(fits))
                if fits.all():
                    yield layout, rows, left
                    break
                yield layout, rows[fits], left[fits]
                left, rows = left[~fits], rows[~fits]

    @property
    def misnamed(self) -> int:
        """Messages whose names hardly any other message holds: damaged ones, and no second publisher's."""
        total = self.named.total()
        return sum(n for n in self.named.values() if n <= FEW_ALIKE and n < RARE * total)

    def _layout(self, row: NDArray[np.uint8]) -> Layout | None:
        for layout in self._layouts:
            if layout.length == row.size and bool((row[layout.fixed] == layout.expected).all()):
                return layout
        try:
            layout = _Walk(row.tobytes(), self.definitions, self._ros1, self._keys).layout(self._topic.message_type)
        except (struct.error, IndexError, KeyError, RecursionError):
            return None
        self._layouts = [layout, *self._layouts[: REMEMBERED - 1]]
        return layout


def _definitions(topic: Topic, *, ros1: bool) -> Any:
    """Fields of the topic's message type and of all types in it. Raises SignalError when one is not known."""
    store: Any = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
    definitions = dict(store.fielddefs)
    try:
        if topic.message_type not in definitions:
            given: Any = {}
            if topic.definition_format == "idl":
                for part in re.split(r"^={80}\nIDL: .*\n", topic.definition, flags=re.MULTILINE):
                    given |= get_types_from_idl(part) if part.strip() else {}
            else:
                given = get_types_from_msg(topic.definition, topic.message_type)
            definitions = {**given, **definitions}
        _check_known(definitions, topic.message_type)
    except Exception as error:
        raise SignalError(
            f"{topic.name} is of type {topic.message_type}, which neither ROS nor the bag defines: name another topic."
        ) from error
    return definitions


def _check_known(definitions: Any, message_type: str) -> None:
    """Raise KeyError when a type within `message_type` has no definition."""
    for _, (kind, detail) in definitions[message_type][1]:
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            kind, detail = detail[0]
        if kind == Nodetype.NAME:
            _check_known(definitions, detail)


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


def joint_numbers(layout: Layout, field_name: str, count: int) -> Numbers | None:
    """Where `field_name` stands in a JointState of `count` joints; None when the driver left it empty or short."""
    numbers = layout.numbers.get(field_name)
    return numbers if numbers is not None and numbers.count == count and count else None
