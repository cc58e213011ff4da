"""ROS 1 bags walked record by record, without index: an unfinished bag (`.bag.active`) reads as far as it goes.

Format: http://wiki.ros.org/Bags/Format/2.0.
"""

from __future__ import annotations

import contextlib
import mmap
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.compression import decompressed, salvaged
from flex_ident.bags.messages import Block, Topic
from flex_ident.bags.records import MessageRecord, record_blocks
from flex_ident.errors import BagError
from flex_ident.notices import Code, Notice

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, CHUNK, CONNECTION = 2, 5, 7
LENGTH = struct.Struct("<I")
Fields = dict[bytes, memoryview]


def _record(view: memoryview, at: int) -> tuple[Fields, int, int]:
    """Header fields of the record at byte `at`, and where its data begins and ends. Raises struct.error."""
    (size,) = LENGTH.unpack_from(view, at)
    at += LENGTH.size
    header, data = view[at : at + size], at + size
    if len(header) != size:
        raise struct.error("header runs over the end")
    (length,) = LENGTH.unpack_from(view, data)
    return _fields(header), data + LENGTH.size, data + LENGTH.size + length


def _fields(header: memoryview) -> Fields:
    fields: Fields = {}
    at = 0
    while at < len(header):
        (size,) = LENGTH.unpack_from(header, at)
        at += LENGTH.size
        name, equals, _ = bytes(header[at : at + size]).partition(b"=")
        if not equals or at + size > len(header):
            raise struct.error("a header field is damaged")
        fields[name] = header[at + len(name) + 1 : at + size]
        at += size
    return fields


def _text(fields: Fields, name: bytes) -> str:
    return bytes(fields.get(name, b"")).decode("utf-8", "replace")


def _times(raw: NDArray[np.uint8]) -> NDArray[np.int64]:
    parts = raw.view("<u4").astype(np.int64)
    times: NDArray[np.int64] = parts[:, 0] * 1_000_000_000 + parts[:, 1]
    return times


class Ros1File:
    """One .bag file of format 2.0. Raises BagError when it is none."""

    ros1 = True

    def __init__(self, path: Path) -> None:
        self.path = path
        self._topics: dict[int, Topic] = {}
        self._notices: list[Notice] = []
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise BagError(f"{path}: is not a ROS 1 bag of format 2.0.")
            self._map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self._described = False

    def topics(self) -> tuple[Topic, ...]:
        """The topics of the bag."""
        if not self._described:
            for contents in self._chunks():
                for _ in record_blocks(contents, self._record_at(contents, frozenset()), _times):
                    pass
            self._notices.clear()
            self._described = True
        return tuple({topic.name: topic for topic in self._topics.values()}.values())

    def notices(self) -> tuple[Notice, ...]:
        """What was lost to damage."""
        return tuple(self._notices)

    def close(self) -> None:
        """Let go of the file; blocks still in use keep it open."""
        with contextlib.suppress(BufferError):
            self._map.close()

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics, about a chunk at a time."""
        self.topics()
        self._notices.clear()
        for contents in self._chunks():
            yield from record_blocks(contents, self._record_at(contents, wanted), _times)

    def _chunks(self) -> Iterator[NDArray[np.uint8]]:
        """The plain contents of each chunk."""
        view, end = memoryview(self._map), len(self._map)
        at, released = len(MAGIC), 0
        while at < end:
            try:
                fields, start, stop = _record(view, at)
                opcode = fields[b"op"][0]
            except (struct.error, KeyError, IndexError):
                self._lost(at, end)
                return
            if opcode == CONNECTION and stop <= end:
                self._describe(fields, view[start:stop])
            elif opcode == CHUNK:
                contents = self._contents(fields, view[start : min(stop, end)], at, cut=stop > end)
                if contents.size:
                    yield contents
                page = at - at % mmap.PAGESIZE
                if page > released and hasattr(mmap, "MADV_DONTNEED"):
                    self._map.madvise(mmap.MADV_DONTNEED, released, page - released)
                    released = page
            if stop > end:
                self._lost(at, end)
                return
            at = stop

    def _lost(self, at: int, end: int) -> None:
        sizes = {"at": at, "size": end, "lost_percent": 100.0 * (end - at) / end}
        said = {"case": "cut", "how": "is cut or damaged"}
        self._notices.append(Notice(Code.BAG_DAMAGED, self.path.name, sizes, said))

    def _contents(self, fields: Fields, packed: memoryview, at: int, *, cut: bool) -> NDArray[np.uint8]:
        compression = _text(fields, b"compression").removeprefix("none")
        if cut:
            return salvaged(packed, compression)
        try:
            (size,) = LENGTH.unpack_from(fields.get(b"size", b"\0\0\0\0"))
            return decompressed(packed, compression, size)
        except (BagError, struct.error):
            self._notices.append(Notice(Code.BAG_DAMAGED, self.path.name, {"at": at}, {"case": "chunk"}))
            return np.zeros(0, np.uint8)

    def _describe(self, fields: Fields, data: memoryview) -> None:
        with contextlib.suppress(struct.error, KeyError):
            (number,) = LENGTH.unpack_from(fields[b"conn"])
            inside = _fields(data)
            package, _, name = _text(inside, b"type").partition("/")
            definition = _text(inside, b"message_definition")
            self._topics.setdefault(number, Topic(_text(fields, b"topic"), f"{package}/msg/{name}", definition))

    def _record_at(self, data: NDArray[np.uint8], wanted: frozenset[str]) -> Callable[[int], MessageRecord | int]:
        view = memoryview(data)  # type: ignore[arg-type]
        end = len(view)
        met: dict[tuple[int, ...], MessageRecord] = {}

        def record_at(at: int) -> MessageRecord | int:
            if at >= end:
                return 0
            try:
                fields, start, stop = _record(view, at)
                if stop > end:
                    return 0
                opcode = fields[b"op"][0]
                if opcode == CONNECTION:
                    self._describe(fields, view[start:stop])
                if opcode != MESSAGE:
                    return stop - at
                (number,) = LENGTH.unpack_from(fields[b"conn"])
                time = _offset(view[at:start], b"time=", fields[b"time"])
            except (struct.error, KeyError, IndexError):
                return 0
            key = (number, stop - at, start - at, time)
            record = met.get(key)
            if record is None:
                topic = self._topics.get(number)
                name = topic.name if topic is not None and topic.name in wanted else None
                head = np.arange(start - at)
                alike = head[(head < time) | (head >= time + 8)]
                record = met[key] = MessageRecord(name, stop - at, time, start - at, stop - start, alike, time)
            return record

        return record_at


def _offset(record: memoryview, name: bytes, value: memoryview) -> int:
    """Where the 8 bytes of the receive time stand in a record. Raises struct.error when there are not 8."""
    at = bytes(record).find(name)
    if len(value) != 8 or at < 0:
        raise struct.error("the time of a message is damaged")
    return at + len(name)
