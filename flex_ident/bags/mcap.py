"""MCAP files walked record by record, without index or summary: an unfinished file reads as far as it goes.

A chunk whose records all have the same length (one topic, constant layout, as a recorder of joint states writes it)
is taken as one strided array; any other chunk record by record. Format: the MCAP specification, version 0.
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.compression import decompressed
from flex_ident.bags.messages import Block, Topic, block_of
from flex_ident.errors import BagError
from flex_ident.recording import Notice

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15
RECORD = struct.Struct("<BQ")
MESSAGE_HEAD = 2 + 4 + 8 + 8
HEAD = RECORD.size + MESSAGE_HEAD
LIMIT = 1 << 40


def _text(data: memoryview, at: int) -> tuple[str, int]:
    (size,) = struct.unpack_from("<I", data, at)
    at += 4
    if at + size > len(data):
        raise struct.error("string runs over the end")
    return bytes(data[at : at + size]).decode("utf-8", "replace"), at + size


class McapFile:
    """One MCAP file. Raises BagError when it is none."""

    ros1 = False

    def __init__(self, path: Path, *, message_zstd: bool = False) -> None:
        self.path = path
        self._message_zstd = message_zstd
        self._schemas: dict[int, tuple[str, str, str]] = {}
        self._channels: dict[int, Topic] = {}
        self._notices: list[Notice] = []
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise BagError(f"{path}: is not an MCAP file.")
            self._map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self._scanned = False

    def topics(self) -> tuple[Topic, ...]:
        """The topics announced anywhere in the file."""
        if not self._scanned:
            for _ in self._chunks(describe_only=True):
                pass
            self._notices.clear()
            self._scanned = True
        found: dict[str, Topic] = {}
        for topic in self._channels.values():
            found.setdefault(topic.name, topic)
        return tuple(found.values())

    def notices(self) -> tuple[Notice, ...]:
        """What was lost to damage."""
        return tuple(self._notices)

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics, about a chunk at a time."""
        self.topics()
        for data in self._chunks(describe_only=False):
            yield from self._messages(data, wanted)

    def _lost(self, at: int, why: str) -> None:
        size = len(self._map)
        share = 100.0 * (size - at) / size
        text = (
            f"{self.path.name} {why} at byte {at} of {size}: the last {share:.1f} % are lost, what is whole was read."
        )
        self._notices.append(Notice("bag_damaged", text))

    def _chunks(self, *, describe_only: bool) -> Iterator[NDArray[np.uint8]]:
        """The decompressed contents of each chunk, and runs of messages outside of chunks."""
        view = memoryview(self._map)
        whole = np.frombuffer(self._map, np.uint8)
        at, end = len(MAGIC), len(view)
        loose_start: int | None = None
        while at < end:
            if end - at < RECORD.size:
                self._lost(at, "is cut")
                break
            opcode, size = RECORD.unpack_from(view, at)
            body = at + RECORD.size
            if opcode == 0 or size > LIMIT or (opcode > 15 and opcode < 0x80):
                if bytes(view[at : at + 8]) != MAGIC:
                    self._lost(at, "is damaged")
                break
            if loose_start is not None and opcode != MESSAGE:
                yield whole[loose_start:at]
                loose_start = None
            if body + size > end:
                if opcode == CHUNK and not describe_only:
                    yield from self._partial_chunk(view[body:end])
                self._lost(at, "is cut")
                at = end
                loose_start = None
                break
            if opcode == MESSAGE and loose_start is None:
                loose_start = at
            elif opcode in (SCHEMA, CHANNEL):
                self._describe(opcode, view[body : body + size])
            elif opcode == CHUNK:
                if describe_only:
                    self._describe_chunk(view[body : body + size])
                else:
                    contents = self._contents(view[body : body + size], at)
                    if contents is not None:
                        yield contents
            elif opcode == DATA_END:
                break
            at = body + size
        else:
            if loose_start is None and not describe_only:
                self._notices.append(Notice("bag_unfinished", f"{self.path.name} was not closed: read to its end."))
        if loose_start is not None:
            yield whole[loose_start:at]

    def _describe_chunk(self, chunk: memoryview) -> None:
        """Schemas and channels inside a chunk; they stand before the first message that needs them."""
        contents = self._contents(chunk, -1)
        if contents is None:
            return
        view = memoryview(contents)  # type: ignore[arg-type]
        at = 0
        while at + RECORD.size <= len(view):
            opcode, size = RECORD.unpack_from(view, at)
            if opcode in (SCHEMA, CHANNEL):
                self._describe(opcode, view[at + RECORD.size : at + RECORD.size + size])
            elif opcode == MESSAGE:
                stride = RECORD.size + size
                count = (len(view) - at) // stride
                heads = contents[at : at + count * stride].reshape(count, stride)
                same = (heads[:, : RECORD.size] == heads[0, : RECORD.size]).all(axis=1)
                run = count if same.all() else int(np.argmin(same))
                at += run * stride
                continue
            at += RECORD.size + size

    def _describe(self, opcode: int, data: memoryview) -> None:
        try:
            (number,) = struct.unpack_from("<H", data, 0)
            if opcode == SCHEMA:
                name, at = _text(data, 2)
                encoding, at = _text(data, at)
                definition, _ = _text(data, at)
                self._schemas[number] = (name, encoding, definition)
            else:
                (schema,) = struct.unpack_from("<H", data, 2)
                topic, _ = _text(data, 4)
                name, encoding, definition = self._schemas.get(schema, ("", "", ""))
                form = "idl" if encoding == "ros2idl" else "msg"
                self._channels[number] = Topic(topic, name, definition, form)
        except struct.error as error:
            raise BagError(
                f"{self.path}: a {'schema' if opcode == SCHEMA else 'channel'} record is damaged."
            ) from error

    def _contents(self, chunk: memoryview, at: int) -> NDArray[np.uint8] | None:
        try:
            (size,) = struct.unpack_from("<Q", chunk, 16)
            compression, start = _text(chunk, 28)
            (length,) = struct.unpack_from("<Q", chunk, start)
            return decompressed(chunk[start + 8 : start + 8 + length], compression, size)
        except (struct.error, BagError, ValueError):
            if at >= 0:
                self._notices.append(
                    Notice("bag_damaged", f"{self.path.name}: the chunk at byte {at} is damaged and was left out.")
                )
            return None

    def _partial_chunk(self, chunk: memoryview) -> Iterator[NDArray[np.uint8]]:
        """The records in front of the cut of a chunk that is not compressed."""
        try:
            compression, start = _text(chunk, 28)
        except struct.error:
            return
        if compression == "" and len(chunk) > start + 8:
            yield np.frombuffer(chunk[start + 8 :], np.uint8)

    def _messages(self, data: NDArray[np.uint8], wanted: frozenset[str]) -> Iterator[Block]:
        view = memoryview(data)  # type: ignore[arg-type]
        at, end = 0, data.size
        pending: dict[int, tuple[list[int], list[int], list[int]]] = {}
        while at + RECORD.size <= end:
            opcode, size = RECORD.unpack_from(view, at)
            stride = RECORD.size + size
            if at + stride > end:
                break
            if opcode != MESSAGE:
                if opcode in (SCHEMA, CHANNEL):
                    self._describe(opcode, view[at + RECORD.size : at + stride])
                at += stride
                continue
            count = (end - at) // stride
            if count >= 8:
                records = data[at : at + count * stride].reshape(count, stride)
                # opcode, length and channel: the same in every record of the run
                same = (records[:, :11] == records[0, :11]).all(axis=1)
                run = count if same.all() else int(np.argmin(same))
                if run >= 8:
                    yield from self._run(records[:run], at, data, wanted)
                    at += run * stride
                    continue
            channel = view[at + 9] | view[at + 10] << 8
            topic = self._channels.get(channel)
            if topic is not None and topic.name in wanted:
                received, starts, lengths = pending.setdefault(channel, ([], [], []))
                received.append(struct.unpack_from("<Q", view, at + 15)[0])
                starts.append(at + HEAD)
                lengths.append(size - MESSAGE_HEAD)
            at += stride
        for channel, (received, starts, lengths) in pending.items():
            yield self._block(channel, np.array(received, np.int64), data, np.array(starts), np.array(lengths))

    def _run(
        self, records: NDArray[np.uint8], at: int, data: NDArray[np.uint8], wanted: frozenset[str]
    ) -> Iterator[Block]:
        channel = int(records[0, 9]) | int(records[0, 10]) << 8
        topic = self._channels.get(channel)
        if topic is None or topic.name not in wanted:
            return
        count, stride = records.shape
        received = np.ascontiguousarray(records[:, 15:23]).view("<i8").ravel().astype(np.int64)
        starts = at + HEAD + stride * np.arange(count, dtype=np.int64)
        yield self._block(channel, received, data, starts, np.full(count, stride - HEAD, np.int64))

    def _block(
        self,
        channel: int,
        received: NDArray[np.int64],
        data: NDArray[np.uint8],
        starts: NDArray[np.int64],
        lengths: NDArray[np.int64],
    ) -> Block:
        block = Block(self._channels[channel].name, received, data, starts, lengths)
        if not self._message_zstd:
            return block
        payloads = [bytes(decompressed(memoryview(block.payload(i)), "zstd", 0)) for i in range(received.size)]
        return block_of(block.topic, received.tolist(), payloads)
