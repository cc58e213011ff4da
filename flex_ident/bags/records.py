"""Messages found in a stretch of records of a file, as few arrays as possible.

A recorder writes the same few messages in the same order over and over: one topic's alone, or those of all topics
that a control loop publishes. Such a cycle of records of constant length is found once, and its repeats are taken
together, one strided array a topic. What does not repeat is taken record by record.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.messages import ROWS, Block
from flex_ident.errors import BagError

LONGEST_CYCLE = 12
FEWEST_REPEATS = 4
MOST_TOGETHER = 1 << 16
"""Repeats of a cycle that are compared at once."""
PATIENCE = 8
"""Records to go on by one after a cycle was looked for in vain."""


class MessageRecord(NamedTuple):
    """One kind of message record; the same object for each of its messages. Offsets count from its first byte."""

    topic: str | None
    """None: not wanted."""
    source: int
    """Number of its channel or connection."""
    stride: int
    """Bytes to the next record."""
    time: int
    """Offset of the 8 bytes of its receive time."""
    payload: int
    """Offset of its payload."""
    length: int
    """Bytes of its payload."""
    alike: NDArray[np.intp]
    """Offsets of the bytes that are the same in every message of this kind."""
    prefix: int
    """How many of those stand at the front without a gap."""


BYTES_PER_RECORD = 8
"""Bytes of a file, as it is on the disk, for each record that is looked at by itself: honest ones take more."""


class RecordBudget:
    """How many records of the file `name`, of `size` bytes on the disk, may be looked at one by one.

    `free` ones are allowed in any file.
    """

    def __init__(self, name: str, size: int, free: int) -> None:
        self._name, self._size = name, size
        self._left = self._most = free + size // BYTES_PER_RECORD

    def take(self) -> None:
        """Note one more record. Raises BagError when there are too many."""
        self._left -= 1
        if self._left < 0:
            raise BagError(
                f"{self._name}: holds over {self._most} tiny records in {self._size} bytes: this is no recording."
            )


Times = Callable[[NDArray[np.uint8]], NDArray[np.int64]]


@dataclass
class Tally:
    """Messages met of each channel or connection, wanted or not, and where the last walk through a stretch ended."""

    messages: Counter[int] = field(default_factory=Counter)
    stopped_at: int = 0


def record_blocks(
    data: NDArray[np.uint8], record_at: Callable[[int], MessageRecord | int], times_ns: Times, tally: Tally
) -> Iterator[Block]:
    """The wanted messages in a stretch of records, in blocks; each topic's in the order of the file.

    `record_at(i)` is the message at byte i, or the bytes to skip where there is none (0: stop). `times_ns` turns the
    bytes (k, 8) of receive times into ns. All messages are counted in `tally`.
    """
    tally.stopped_at = 0
    view = memoryview(data.data)
    at, end, wait = 0, data.size, 0
    recent: list[MessageRecord] = []
    pending = _Pending(data, times_ns)
    counts = tally.messages
    while at < end:
        record = record_at(at)
        if isinstance(record, int):
            if record <= 0:
                break
            at += record
            recent.clear()
            continue
        if wait == 0:
            cycle, repeats = _cycle(view, data, at, record, recent)
            if repeats:
                for own in cycle:
                    counts[own.source] += repeats
                yield from _repeated(data, at, cycle, repeats, pending, times_ns)
                at += repeats * sum(r.stride for r in cycle)
                recent = list(cycle)
                continue
            wait = PATIENCE if len(recent) >= LONGEST_CYCLE else 0
        else:
            wait -= 1
        recent.append(record)
        if len(recent) > LONGEST_CYCLE:
            del recent[0]
        counts[record.source] += 1
        if record.topic is not None:
            yield from pending.add(record, at)
        at += record.stride
    tally.stopped_at = at
    yield from pending.rest()


class _Pending:
    """Single messages that wait to become a block."""

    def __init__(self, data: NDArray[np.uint8], times_ns: Times) -> None:
        self._data, self._times_ns = data, times_ns
        self._places: dict[str, tuple[list[int], list[int], list[int]]] = {}

    def add(self, record: MessageRecord, at: int) -> Iterator[Block]:
        times, starts, lengths = self._places.setdefault(record.topic or "", ([], [], []))
        times.append(at + record.time)
        starts.append(at + record.payload)
        lengths.append(record.length)
        if len(times) >= ROWS:
            yield from self.flushed(record.topic or "")

    def flushed(self, topic: str) -> Iterator[Block]:
        """The block of one topic's messages so far, if there are any."""
        if topic in self._places:
            times, starts, lengths = (np.array(column, np.int64) for column in self._places.pop(topic))
            stamps = np.lib.stride_tricks.sliding_window_view(self._data, 8)[times]
            yield Block(topic, self._times_ns(stamps), self._data, starts, lengths)

    def rest(self) -> Iterator[Block]:
        """The blocks of all topics."""
        for topic in list(self._places):
            yield from self.flushed(topic)


def _cycle(
    view: memoryview, data: NDArray[np.uint8], at: int, record: MessageRecord, recent: list[MessageRecord]
) -> tuple[list[MessageRecord], int]:
    """The cycle of records that begins at byte `at` as it did lately, and how often it repeats from there; 0: none."""
    beyond = at + record.stride
    if view[at : at + record.prefix] == view[beyond : beyond + record.prefix]:
        repeats = 1 + _repeats(data, beyond, [record], record.stride)
        if repeats >= FEWEST_REPEATS:
            return [record], repeats
    for k in range(2, len(recent) + 1):
        if recent[-k] is not record:
            continue
        cycle = recent[-k:]
        size = sum(r.stride for r in cycle)
        place = at
        for own in cycle:
            if view[place : place + own.prefix] != view[place - size : place - size + own.prefix]:
                break
            place += own.stride
        else:
            repeats = _repeats(data, at, cycle, size)
            if repeats >= FEWEST_REPEATS:
                return cycle, repeats
    return [], 0


def _starts(cycle: list[MessageRecord]) -> list[int]:
    """Where each record of the cycle begins."""
    return [0, *accumulate(r.stride for r in cycle)][:-1]


def _repeats(data: NDArray[np.uint8], at: int, cycle: list[MessageRecord], size: int) -> int:
    """How often the cycle, of `size` bytes, stands in a row from byte `at` on; the one before it is the pattern."""
    alike = np.concatenate([r.alike + start for r, start in zip(cycle, _starts(cycle), strict=True)])
    head = data[at - size + alike]
    most = (data.size - at) // size
    found, window = 0, FEWEST_REPEATS
    while found < most:
        count = min(window, most - found)
        start = at + found * size
        rows = data[start : start + count * size].reshape(count, size)
        same = (rows[:, alike] == head).all(axis=1)
        if not same.all():
            return found + int(np.argmin(same))
        found += count
        window = min(8 * window, MOST_TOGETHER)
    return found


def _repeated(
    data: NDArray[np.uint8], at: int, cycle: list[MessageRecord], repeats: int, pending: _Pending, times_ns: Times
) -> Iterator[Block]:
    """The messages of the cycle's repeats, topic by topic."""
    size = sum(r.stride for r in cycle)
    windows = np.lib.stride_tricks.sliding_window_view(data, 8)
    for topic in dict.fromkeys(r.topic for r in cycle):
        if topic is None:
            continue
        yield from pending.flushed(topic)
        own = [(r, start) for r, start in zip(cycle, _starts(cycle), strict=True) if r.topic == topic]
        times = np.array([start + r.time for r, start in own], np.int64)
        payloads = np.array([start + r.payload for r, start in own], np.int64)
        lengths = np.array([r.length for r, _ in own], np.int64)
        most = max(1, ROWS // len(own))
        for first in range(0, repeats, most):
            count = min(most, repeats - first)
            begins = at + size * (first + np.arange(count, dtype=np.int64))[:, None]
            received = times_ns(windows[(begins + times).ravel()])
            yield Block(topic, received, data, (begins + payloads).ravel(), np.tile(lengths, count))
