"""ROS 1 bags walked record by record, without index: an unfinished bag (`.bag.active`) reads as far as it goes.

Format: http://wiki.ros.org/Bags/Format/2.0.
"""

from __future__ import annotations

import contextlib
import mmap
import struct
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.compression import Budget, TooMuchError, decompressed, salvaged
from flex_ident.bags.messages import Block, Topic
from flex_ident.bags.records import MessageRecord, RecordBudget, Tally, record_blocks
from flex_ident.errors import BagError
from flex_ident.notices import Code, Notice
from flex_ident.recording.names import decoded, path_text

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, BAG_HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7
LENGTH = struct.Struct("<I")
Fields = dict[bytes, memoryview]
KNOWN = (MESSAGE, BAG_HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION)
MOST_FIELDS = 64
"""Fields of a header, at most."""
MOST_OTHERS = 1 << 17
"""Records of a chunk that are no messages, at most."""

FREE_RECORDS = 1 << 16
"""Records that may be looked at one by one in any file."""


class _Chunk(NamedTuple):
    """The plain contents of the chunk at byte `at`."""

    at: int
    contents: NDArray[np.uint8]
    cut: bool


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
        if not equals or at + size > len(header) or len(fields) >= MOST_FIELDS:
            raise struct.error("a header field is damaged")
        fields[name] = header[at + len(name) + 1 : at + size]
        at += size
    return fields


def _text(fields: Fields, name: bytes) -> str:
    return decoded(bytes(fields.get(name, b"")))


def _times(raw: NDArray[np.uint8]) -> NDArray[np.int64]:
    parts = raw.view("<u4").astype(np.int64)
    times: NDArray[np.int64] = parts[:, 0] * 1_000_000_000 + parts[:, 1]
    return times


class Ros1File:
    """One .bag file of format 2.0, opened as `file`; `path` is its name. Raises BagError when it is none."""

    ros1 = True

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self.name = path_text(Path(path.name))
        self._topics: dict[int, Topic] = {}
        self._notices: list[Notice] = []
        self._tally = Tally()
        self._indexed: Counter[int] = Counter()
        """Messages of each connection by the index that follows each chunk."""
        self._summed: Counter[int] = Counter()
        """The same by the summary of all chunks at the end."""
        self._budget = Budget()
        self._size = path.stat().st_size
        self._records = self._all_records()
        self._map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        if self._map[: len(MAGIC)] != MAGIC:
            raise BagError(f"{path_text(path)}: is not a ROS 1 bag of format 2.0.")
        self._described = False

    def _all_records(self) -> RecordBudget:
        return RecordBudget(self.name, self._size, FREE_RECORDS)

    def topics(self) -> tuple[Topic, ...]:
        """The topics of the bag."""
        if not self._described:
            for _ in self._walk(frozenset()):
                pass
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
        yield from self._walk(wanted)

    def announced(self) -> dict[str, int]:
        """Messages of each topic by the indexes of the chunks, or by their summary where it says more."""
        found: dict[str, int] = {}
        for number, topic in self._topics.items():
            count = max(self._indexed[number], self._summed[number])
            if count:
                found[topic.name] = found.get(topic.name, 0) + count
        return found

    def _walk(self, wanted: frozenset[str]) -> Iterator[Block]:
        """The wanted messages of all chunks; every message is counted, and all damage noted."""
        self._notices.clear()
        self._tally, self._indexed, self._summed, self._budget = Tally(), Counter(), Counter(), Budget()
        self._records = self._all_records()
        for stretch in self._chunks():
            at, contents, cut = stretch
            before = self._tally.messages.total()
            yield from record_blocks(contents, self._record_at(contents, wanted), _times, self._tally)
            stop = self._tally.stopped_at
            if stop < contents.size and not cut:
                read = self._tally.messages.total() - before
                sizes = {"at": at, "inside": stop, "size": contents.size, "read": read}
                self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "rest_of_chunk"}))
                self._waste(at, contents.size - stop)
            del stretch, contents  # before the next one needs room
        nameless = sum(n for number, n in self._tally.messages.items() if number not in self._topics)
        if nameless:
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"count": nameless}, {"case": "nameless"}))

    def _waste(self, at: int, size: int) -> None:
        """Note bytes of a chunk that are no messages. Raises BagError when a hostile file brings too many."""
        try:
            self._budget.waste(size)
        except TooMuchError as error:
            raise self._too_much(at, error) from error

    def _too_much(self, at: int, error: TooMuchError) -> BagError:
        return BagError(f"{self.name}: the chunk at byte {at} {error}")

    def _chunks(self) -> Iterator[_Chunk]:
        """The plain contents of each chunk."""
        view, end = memoryview(self._map), len(self._map)
        at, released, summary = len(MAGIC), 0, 0
        while at < end:
            self._records.take()
            try:
                fields, start, stop = _record(view, at)
                opcode = fields[b"op"][0]
            except (struct.error, KeyError, IndexError):
                self._lost(at, end)
                return
            whole = stop <= end
            if opcode == CONNECTION and whole:
                self._describe(fields, view[start:stop])
            elif opcode == BAG_HEADER:
                with contextlib.suppress(struct.error, KeyError):
                    (summary,) = struct.unpack_from("<Q", fields[b"index_pos"])
            elif opcode == INDEX and whole:
                self._take_counts(fields, b"conn", b"count")
            elif opcode == CHUNK_INFO and whole:
                for number, count in struct.iter_unpack("<II", view[start : stop - (stop - start) % 8]):
                    self._summed[number] += count
            elif opcode == CHUNK:
                contents = self._contents(fields, view[start : min(stop, end)], at, cut=not whole)
                if contents.size:
                    yield _Chunk(at, contents, cut=not whole)
                del contents
                page = at - at % mmap.PAGESIZE
                if page > released and hasattr(mmap, "MADV_DONTNEED"):
                    self._map.madvise(mmap.MADV_DONTNEED, released, page - released)
                    released = page
            elif opcode not in KNOWN:
                self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"at": at}, {"case": "unknown_record"}))
            if not whole:
                self._lost(at, end)
                return
            at = stop
        if not summary:
            self._notices.append(Notice(Code.BAG_UNFINISHED, self.name))
        elif summary >= end:
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"size": end}, {"case": "end"}))

    def _take_counts(self, fields: Fields, source: bytes, count: bytes) -> None:
        """Count the messages of one connection by the index of the chunk before it."""
        with contextlib.suppress(struct.error, KeyError):
            (number,), (messages,) = LENGTH.unpack_from(fields[source]), LENGTH.unpack_from(fields[count])
            self._indexed[number] += messages

    def _lost(self, at: int, end: int) -> None:
        sizes = {"at": at, "size": end, "lost_percent": 100.0 * (end - at) / end}
        said = {"case": "cut", "how": "is cut or damaged"}
        self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, said))

    def _contents(self, fields: Fields, packed: memoryview, at: int, *, cut: bool) -> NDArray[np.uint8]:
        compression = _text(fields, b"compression").removeprefix("none")
        if cut:
            return salvaged(packed, compression, None, self._budget)
        try:
            (size,) = LENGTH.unpack_from(fields.get(b"size", b"\0\0\0\0"))
            return decompressed(packed, compression, size, self._budget)
        except TooMuchError as error:
            raise self._too_much(at, error) from error
        except (BagError, struct.error):
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"at": at}, {"case": "chunk"}))
            return np.zeros(0, np.uint8)

    def _describe(self, fields: Fields, data: memoryview) -> None:
        with contextlib.suppress(struct.error, KeyError):
            (number,) = LENGTH.unpack_from(fields[b"conn"])
            inside = _fields(data)
            package, _, name = _text(inside, b"type").partition("/")
            definition = bytes(inside.get(b"message_definition", b"")).decode("utf-8", "replace")
            self._topics.setdefault(number, Topic(_text(fields, b"topic"), f"{package}/msg/{name}", definition))

    def _record_at(self, data: NDArray[np.uint8], wanted: frozenset[str]) -> Callable[[int], MessageRecord | int]:
        view = memoryview(data)  # type: ignore[arg-type]
        end = len(view)
        met: dict[tuple[int, ...], MessageRecord] = {}

        others = 0

        def record_at(at: int) -> MessageRecord | int:
            nonlocal others
            if at >= end:
                return 0
            self._records.take()
            try:
                fields, start, stop = _record(view, at)
                if stop > end:
                    return 0
                opcode = fields[b"op"][0]
                if opcode != MESSAGE:
                    others += 1
                    if opcode != CONNECTION or others > MOST_OTHERS:
                        return 0
                    self._describe(fields, view[start:stop])
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
                record = met[key] = MessageRecord(name, number, stop - at, time, start - at, stop - start, alike, time)
            return record

        return record_at


def _offset(record: memoryview, name: bytes, value: memoryview) -> int:
    """Where the 8 bytes of the receive time stand in a record. Raises struct.error when there are not 8."""
    at = bytes(record).find(name)
    if len(value) != 8 or at < 0:
        raise struct.error("the time of a message is damaged")
    return at + len(name)
