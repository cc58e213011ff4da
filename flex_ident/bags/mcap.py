"""MCAP files walked record by record, without index: an unfinished file reads as far as it goes.

A run of messages of one topic and length, as a recorder of joint states writes it, is taken as one strided array.
Format: the MCAP specification, version 0.
"""

from __future__ import annotations

import bisect
import contextlib
import mmap
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.compression import Budget, TooMuchError, decompressed, salvaged
from flex_ident.bags.joint_messages import described_topic
from flex_ident.bags.messages import Block, Topic
from flex_ident.bags.records import MessageRecord, RecordBudget, Tally, record_blocks
from flex_ident.errors import BagError
from flex_ident.notices import Code, Notice
from flex_ident.recording.names import decoded, path_text

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, STATISTICS, DATA_END = (
    2, 3, 4, 5, 6, 7, 8, 11, 15,
)  # fmt: skip
RECORD = struct.Struct("<BQ")
LAST_STANDARD, FIRST_PRIVATE = 15, 0x80
FOOTER_BYTES = RECORD.size + 8 + 8 + 4
PAYLOAD = RECORD.size + 2 + 4 + 8 + 8
"""Opcode and length, then channel, sequence number, log time and publish time."""
LOG_TIME = RECORD.size + 2 + 4
ALIKE = np.arange(RECORD.size + 2)
LOOSE = 1 << 23
"""Bytes of messages outside of chunks that are taken together."""
MOST_DESCRIPTIONS = 1 << 17
"""Schemas and channels of a stretch, at most: each has a number of 16 bits."""
FREE_RECORDS = 1 << 18
"""Records that may be looked at one by one in any file."""
CHECKSUM_BYTES = 4
CHUNK_OFFSET, CHUNK_OFFSET_END = 16, 24
"""Where a chunk's index holds the byte at which the chunk begins: behind the times of its messages."""
INDEX_ENTRY = 16
"""Bytes for each message in the index of a chunk."""


class _Stretch(NamedTuple):
    """Records of messages, schemas and channels: a chunk's plain contents, or what stands outside of chunks."""

    at: int
    contents: NDArray[np.uint8]
    cut: bool = False


def _raw(data: memoryview, at: int) -> tuple[bytes, int]:
    (size,) = struct.unpack_from("<I", data, at)
    at += 4
    if at + size > len(data):
        raise struct.error("string runs over the end")
    return bytes(data[at : at + size]), at + size


def _text(data: memoryview, at: int) -> tuple[str, int]:
    raw, at = _raw(data, at)
    return decoded(raw), at


def _log_times(raw: NDArray[np.uint8]) -> NDArray[np.int64]:
    return raw.view("<i8").ravel().astype(np.int64)


class McapFile:
    """One MCAP file, opened as `file`; `path` is its name. Raises BagError when it is none."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self.name = path_text(Path(path.name))
        self.ros1 = False
        """Whether its messages are serialised as in ROS 1, as `mcap convert` leaves them; known after `topics`."""
        self._schemas: dict[int, tuple[str, str, bytes]] = {}
        self._channels: dict[int, Topic] = {}
        self._counts: dict[int, int] = {}
        self._notices: list[Notice] = []
        self._tally = Tally()
        self._chunks: list[int] = []
        """Where the chunks begin, by the summary."""
        self._indexed: Counter[int] = Counter()
        """Messages of each channel by the indexes that follow the chunks."""
        self._descriptions = self._short = 0
        self._undescribed: Counter[str] = Counter()
        """Schemas and channels that could not be read, of each kind."""
        self._budget = Budget()
        self._size = path.stat().st_size
        self._records = self._all_records()
        self._map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        if self._map[: len(MAGIC)] != MAGIC:
            raise BagError(f"{path_text(path)}: is not an MCAP file.")
        self._described = False

    def _all_records(self) -> RecordBudget:
        return RecordBudget(self.name, self._size, FREE_RECORDS)

    def topics(self) -> tuple[Topic, ...]:
        """The topics announced in the summary, or else anywhere in the file."""
        if not self._described:
            self._describe_summary()
            self._chunks.sort()
            if not self._channels:
                for _ in self._walk(frozenset()):
                    pass
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
        if self.topics():  # without any, all of it has been walked already
            yield from self._walk(wanted)

    def announced(self) -> dict[str, int]:
        """Messages of each topic by the summary, or by the indexes of the chunks where they say more."""
        found: dict[str, int] = {}
        for number, topic in self._channels.items():
            count = max(self._counts.get(number, 0), self._indexed[number])
            if count:
                found[topic.name] = found.get(topic.name, 0) + count
        return found

    def _walk(self, wanted: frozenset[str]) -> Iterator[Block]:
        """The wanted messages of all stretches; every message is counted, and all damage noted."""
        self._notices.clear()
        self._tally, self._indexed, self._budget = Tally(), Counter(), Budget()
        self._short, self._records = 0, self._all_records()
        self._undescribed.clear()
        for stretch in self._stretches():
            at, contents, cut = stretch
            before, self._descriptions = self._tally.messages.total(), 0
            yield from record_blocks(contents, self._record_at(contents, wanted), _log_times, self._tally)
            stop = self._tally.stopped_at
            if stop < contents.size and not cut:
                read = self._tally.messages.total() - before
                sizes = {"at": at, "inside": stop, "size": contents.size, "read": read}
                self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "rest_of_chunk"}))
                self._waste(at, contents.size - stop)
            del stretch, contents  # before the next one needs room
        nameless = sum(n for number, n in self._tally.messages.items() if number not in self._channels)
        if nameless:
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"count": nameless}, {"case": "nameless"}))
        if self._short:
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"count": self._short}, {"case": "short"}))
        for kind, count in self._undescribed.items():
            texts = {"case": "record", "kind": kind}
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"count": count}, texts))

    def _waste(self, at: int, size: int) -> None:
        """Note bytes of a chunk that are no messages. Raises BagError when a hostile file brings too many."""
        try:
            self._budget.waste(size)
        except TooMuchError as error:
            raise self._too_much(at, error) from error

    def _too_much(self, at: int, error: TooMuchError) -> BagError:
        return BagError(f"{self.name}: the chunk at byte {at} {error}")

    def _lost(self, at: int, why: str) -> None:
        size = len(self._map)
        sizes = {"at": at, "size": size, "lost_percent": 100.0 * (size - at) / size}
        self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "cut", "how": why}))

    def _stretches(self) -> Iterator[_Stretch]:
        """The contents of each chunk, and what stands outside of them."""
        view, whole = memoryview(self._map), np.frombuffer(self._map, np.uint8)
        at, end = len(MAGIC), len(view)
        loose = at
        """From here to `at`, records outside of chunks."""
        released, ended = 0, False
        while at + RECORD.size <= end:
            self._records.take()
            opcode, size = RECORD.unpack_from(view, at)
            body, follower = at + RECORD.size, at + RECORD.size + size
            unknown = opcode == 0 or LAST_STANDARD < opcode < FIRST_PRIVATE
            if opcode not in (MESSAGE, SCHEMA, CHANNEL) or follower > end or at - loose > LOOSE:
                if at > loose:
                    yield _Stretch(loose, whole[loose:at])
                loose = at
            if opcode == FOOTER and follower + len(MAGIC) == end:
                return
            if ended and (unknown or follower > end or opcode == FOOTER):
                self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"at": at, "size": end}, {"case": "summary"}))
                return
            damaged = unknown or opcode == FOOTER
            if (damaged or follower > end) and (further := self._next_chunk(at)):
                sizes = {"at": at, "further": further, "size": end}
                self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "between"}))
                at = loose = further
                continue
            if damaged:
                self._lost(at, "is damaged")
                return
            ended |= opcode == DATA_END and size == CHECKSUM_BYTES
            if opcode == CHUNK:
                contents = self._contents(view[body : min(follower, end)], at)
                saved = contents.size > 0
                if saved:
                    yield _Stretch(at, contents, cut=follower > end)
                del contents
                released = self._released(released, at)
            if follower > end and opcode == CHUNK and saved:
                sizes = {"at": end, "missing": follower - end}
                self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "cut_chunk"}))
                return
            if follower > end:
                self._lost(at, "is cut")
                return
            if opcode == MESSAGE_INDEX:
                self._take_index(view[body:follower])
            at = follower
            if opcode not in (MESSAGE, SCHEMA, CHANNEL):
                loose = at
        if at > loose:
            yield _Stretch(loose, whole[loose:at])
        if at < end:
            self._lost(at, "is cut")
        else:
            self._notices.append(Notice(Code.BAG_UNFINISHED, self.name))

    def _next_chunk(self, at: int) -> int | None:
        """Where the first chunk behind byte `at` begins, by the summary; None where it names none."""
        i = bisect.bisect_right(self._chunks, at)
        return self._chunks[i] if i < len(self._chunks) else None

    def _take_index(self, index: memoryview) -> None:
        """Count the messages of one channel by the index of the chunk before it."""
        with contextlib.suppress(struct.error):
            channel, size = struct.unpack_from("<HI", index)
            if size == len(index) - 6:
                self._indexed[channel] += size // INDEX_ENTRY

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
                return salvaged(packed, compression, size, self._budget)
            plain = decompressed(packed, compression, size, self._budget)
            if checksum and zlib.crc32(plain.data) != checksum:
                raise BagError("the checksum of a chunk does not agree.")
            return plain
        except TooMuchError as error:
            raise self._too_much(at, error) from error
        except (struct.error, BagError):
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"at": at}, {"case": "chunk"}))
            return np.zeros(0, np.uint8)

    def _describe_summary(self) -> None:
        """Take schemas and channels from the summary at the file's end, if there is one."""
        view, end = memoryview(self._map), len(self._map) - len(MAGIC)
        footer = end - FOOTER_BYTES
        if footer < len(MAGIC) or view[footer] != FOOTER or bytes(view[end:]) != MAGIC:
            return
        (at,) = struct.unpack_from("<Q", view, footer + RECORD.size)
        while len(MAGIC) <= at <= footer - RECORD.size:
            self._records.take()
            opcode, size = RECORD.unpack_from(view, at)
            if not 0 < opcode <= LAST_STANDARD:
                return
            at += RECORD.size
            if opcode in (SCHEMA, CHANNEL) and at + size <= footer:
                self._describe(opcode, view[at : at + size])
            elif opcode == STATISTICS and at + size <= footer:
                self._count(view[at : at + size])
            elif opcode == CHUNK_INDEX and CHUNK_OFFSET_END <= size <= footer - at:
                (chunk,) = struct.unpack_from("<Q", view, at + CHUNK_OFFSET)
                if chunk < footer and view[chunk] == CHUNK:
                    self._chunks.append(chunk)
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
                raw, _ = _raw(data, at)
                self._schemas[number] = (name, encoding, raw)
            elif number not in self._channels:
                (schema,) = struct.unpack_from("<H", data, 2)
                topic, at = _text(data, 4)
                serialisation, _ = _text(data, at)
                self.ros1 |= serialisation == "ros1"
                self._channels[number] = described_topic(
                    topic, serialisation, *self._schemas.get(schema, ("", "", b""))
                )
        except struct.error:
            self._undescribed["schema" if opcode == SCHEMA else "channel"] += 1

    def _record_at(self, data: NDArray[np.uint8], wanted: frozenset[str]) -> Callable[[int], MessageRecord | int]:
        view = memoryview(data)  # type: ignore[arg-type]
        end = len(view)
        met: dict[tuple[int, int], MessageRecord] = {}

        def record_at(at: int) -> MessageRecord | int:
            if at + RECORD.size > end:
                return 0
            self._records.take()
            opcode, size = RECORD.unpack_from(view, at)
            stride = RECORD.size + size
            if at + stride > end or opcode not in (MESSAGE, SCHEMA, CHANNEL):
                return 0
            if opcode != MESSAGE:
                self._descriptions += 1
                if self._descriptions > MOST_DESCRIPTIONS:
                    return 0
                self._describe(opcode, view[at + RECORD.size : at + stride])
                return int(stride)
            if stride < PAYLOAD:
                self._short += 1
                return int(stride)
            channel = view[at + 9] | view[at + 10] << 8
            record = met.get((channel, stride))
            if record is None:
                topic = self._channels.get(channel)
                name = topic.name if topic is not None and topic.name in wanted else None
                record = MessageRecord(name, channel, stride, LOG_TIME, PAYLOAD, stride - PAYLOAD, ALIKE, ALIKE.size)
                met[channel, stride] = record
            return record

        return record_at
