"""MCAP files walked record by record, without index: an unfinished file reads as far as it goes.

A run of messages of one topic and length, as a recorder of joint states writes it, is taken as one strided array.
Format: the MCAP specification, version 0.
"""

from __future__ import annotations

import contextlib
import mmap
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.compression import decompressed, salvaged
from flex_ident.bags.messages import Block, Topic
from flex_ident.bags.records import MessageRecord, record_blocks
from flex_ident.errors import BagError
from flex_ident.notices import Code, Notice

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS, DATA_END = 2, 3, 4, 5, 6, 11, 15
RECORD = struct.Struct("<BQ")
LAST_STANDARD, FIRST_PRIVATE = 15, 0x80
FOOTER_BYTES = RECORD.size + 8 + 8 + 4
PAYLOAD = RECORD.size + 2 + 4 + 8 + 8
"""Opcode and length, then channel, sequence number, log time and publish time."""
LOG_TIME = RECORD.size + 2 + 4
ALIKE = np.arange(RECORD.size + 2)
LOOSE = 1 << 23
"""Bytes of messages outside of chunks that are taken together."""


def _text(data: memoryview, at: int) -> tuple[str, int]:
    (size,) = struct.unpack_from("<I", data, at)
    at += 4
    if at + size > len(data):
        raise struct.error("string runs over the end")
    return bytes(data[at : at + size]).decode("utf-8", "replace"), at + size


def _log_times(raw: NDArray[np.uint8]) -> NDArray[np.int64]:
    return raw.view("<i8").ravel().astype(np.int64)


class McapFile:
    """One MCAP file. Raises BagError when it is none."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.ros1 = False
        """Whether its messages are serialised as in ROS 1, as `mcap convert` leaves them; known after `topics`."""
        self._schemas: dict[int, tuple[str, str, str]] = {}
        self._channels: dict[int, Topic] = {}
        self._counts: dict[int, int] = {}
        self._notices: list[Notice] = []
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise BagError(f"{path}: is not an MCAP file.")
            self._map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self._described = False

    def topics(self) -> tuple[Topic, ...]:
        """The topics announced in the summary, or else anywhere in the file."""
        if not self._described:
            self._describe_summary()
            if not self._channels:
                for contents in self._stretches():
                    for _ in record_blocks(contents, self._record_at(contents, frozenset()), _log_times):
                        pass
            self._notices.clear()
            self._described = True
        found: dict[str, Topic] = {}
        for number, topic in self._channels.items():
            before = found.get(topic.name)
            count = self._counts.get(number)
            if before is not None and before.count is not None and count is not None:
                count += before.count
            found[topic.name] = replace(before or topic, count=count)
        return tuple(found.values())

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
        for contents in self._stretches():
            yield from record_blocks(contents, self._record_at(contents, wanted), _log_times)

    def _lost(self, at: int, why: str) -> None:
        size = len(self._map)
        sizes = {"at": at, "size": size, "lost_percent": 100.0 * (size - at) / size}
        self._notices.append(Notice(Code.BAG_DAMAGED, self.path.name, sizes, {"case": "cut", "how": why}))

    def _stretches(self) -> Iterator[NDArray[np.uint8]]:
        """Stretches of messages, schemas and channels: the contents of each chunk, and what stands outside of them."""
        view, whole = memoryview(self._map), np.frombuffer(self._map, np.uint8)
        at, end = len(MAGIC), len(view)
        loose = at
        """From here to `at`, records outside of chunks."""
        released = 0
        while at + RECORD.size <= end:
            opcode, size = RECORD.unpack_from(view, at)
            body, follower = at + RECORD.size, at + RECORD.size + size
            unknown = opcode == 0 or LAST_STANDARD < opcode < FIRST_PRIVATE
            if opcode not in (MESSAGE, SCHEMA, CHANNEL) or follower > end or at - loose > LOOSE:
                if at > loose:
                    yield whole[loose:at]
                loose = at
            if opcode in (DATA_END, FOOTER):
                return
            if unknown:
                self._lost(at, "is damaged")
                return
            if opcode == CHUNK:
                contents = self._contents(view[body : min(follower, end)], at)
                if contents.size:
                    yield contents
                released = self._released(released, at)
            if follower > end:
                self._lost(at, "is cut")
                return
            at = follower
            if opcode not in (MESSAGE, SCHEMA, CHANNEL):
                loose = at
        if at > loose:
            yield whole[loose:at]
        if at < end:
            self._lost(at, "is cut")
        else:
            self._notices.append(Notice(Code.BAG_UNFINISHED, self.path.name))

    def _released(self, start: int, stop: int) -> int:
        """Take the file's pages from `start` to `stop` out of this process' memory; where the next pages begin."""
        stop -= stop % mmap.PAGESIZE
        if stop > start and hasattr(mmap, "MADV_DONTNEED"):
            self._map.madvise(mmap.MADV_DONTNEED, start, stop - start)
        return max(start, stop)

    def _contents(self, chunk: memoryview, at: int) -> NDArray[np.uint8]:
        """The plain contents (k,) of a chunk, or what can be saved of one that is cut; none of a damaged one."""
        try:
            size, checksum = struct.unpack_from("<QI", chunk, 16)
            compression, start = _text(chunk, 28)
            (length,) = struct.unpack_from("<Q", chunk, start)
            packed = chunk[start + 8 : start + 8 + length]
            if len(packed) < length:
                return salvaged(packed, compression)
            plain = decompressed(packed, compression, size)
            if checksum and zlib.crc32(plain.data) != checksum:
                raise BagError("the checksum of a chunk does not agree.")
            return plain
        except (struct.error, BagError):
            self._notices.append(Notice(Code.BAG_DAMAGED, self.path.name, {"at": at}, {"case": "chunk"}))
            return np.zeros(0, np.uint8)

    def _describe_summary(self) -> None:
        """Take schemas and channels from the summary at the file's end, if there is one."""
        view, end = memoryview(self._map), len(self._map) - len(MAGIC)
        footer = end - FOOTER_BYTES
        if footer < len(MAGIC) or view[footer] != FOOTER or bytes(view[end:]) != MAGIC:
            return
        (at,) = struct.unpack_from("<Q", view, footer + RECORD.size)
        while len(MAGIC) <= at <= footer - RECORD.size:
            opcode, size = RECORD.unpack_from(view, at)
            at += RECORD.size
            if opcode in (SCHEMA, CHANNEL) and at + size <= footer:
                self._describe(opcode, view[at : at + size])
            elif opcode == STATISTICS and at + size <= footer:
                self._count(view[at : at + size])
            at += size

    def _count(self, statistics: memoryview) -> None:
        """Take the count of messages of each channel."""
        with contextlib.suppress(struct.error):
            (size,) = struct.unpack_from("<I", statistics, 42)
            for at in range(46, 46 + size, 10):
                channel, count = struct.unpack_from("<HQ", statistics, at)
                self._counts[channel] = count

    def _describe(self, opcode: int, data: memoryview) -> None:
        try:
            (number,) = struct.unpack_from("<H", data, 0)
            if opcode == SCHEMA:
                name, at = _text(data, 2)
                encoding, at = _text(data, at)
                definition, _ = _text(data, at)
                self._schemas[number] = (name, encoding, definition)
            elif number not in self._channels:
                (schema,) = struct.unpack_from("<H", data, 2)
                topic, at = _text(data, 4)
                serialisation, _ = _text(data, at)
                self.ros1 |= serialisation == "ros1"
                name, encoding, definition = self._schemas.get(schema, ("", "", ""))
                package, _, kind = name.rpartition("/")
                name = name if "/" in package else f"{package}/msg/{kind}"
                self._channels[number] = Topic(topic, name, definition, "idl" if encoding.endswith("idl") else "msg")
        except struct.error:
            kind = "schema" if opcode == SCHEMA else "channel"
            self._notices.append(Notice(Code.BAG_DAMAGED, self.path.name, texts={"case": "record", "kind": kind}))

    def _record_at(self, data: NDArray[np.uint8], wanted: frozenset[str]) -> Callable[[int], MessageRecord | int]:
        view = memoryview(data)  # type: ignore[arg-type]
        end = len(view)
        met: dict[tuple[int, int], MessageRecord] = {}

        def record_at(at: int) -> MessageRecord | int:
            if at + RECORD.size > end:
                return 0
            opcode, size = RECORD.unpack_from(view, at)
            stride = RECORD.size + size
            if at + stride > end:
                return 0
            if opcode != MESSAGE or stride < PAYLOAD:
                if opcode in (SCHEMA, CHANNEL):
                    self._describe(opcode, view[at + RECORD.size : at + stride])
                return int(stride)
            channel = view[at + 9] | view[at + 10] << 8
            record = met.get((channel, stride))
            if record is None:
                topic = self._channels.get(channel)
                name = topic.name if topic is not None and topic.name in wanted else None
                record = MessageRecord(name, stride, LOG_TIME, PAYLOAD, stride - PAYLOAD, ALIKE, ALIKE.size)
                met[channel, stride] = record
            return record

        return record_at
