"""sensor_msgs/JointState decoded a block at a time: a constant layout is one strided array.

The layout (joint names, array lengths) is taken from one message; a message belongs to it when every byte other than
the stamp and the numbers is the same. Messages of another layout, names in another order say, get their own.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.messages import Block
from flex_ident.errors import BagError
from flex_ident.recording import Floats

FIELDS = ("position", "velocity", "effort")
JOINT_STATE = "sensor_msgs/msg/JointState"


@dataclass(frozen=True)
class Layout:
    """Where the numbers stand in a message of `length` bytes; `offsets` and `counts` in the order of FIELDS."""

    names: tuple[str, ...]
    stamp: int
    offsets: tuple[int, int, int]
    counts: tuple[int, int, int]
    big_endian: bool
    fixed: NDArray[np.bool_]
    reference: NDArray[np.uint8]


@dataclass(frozen=True)
class JointStates:
    """k messages: receive times and stamps (k,), ns; `names`; a (k, len(names)) array a field, NaN where left out."""

    received: NDArray[np.int64]
    stamps: NDArray[np.int64]
    names: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats


def layout_of(payload: bytes, *, ros1: bool) -> Layout:
    """The layout of one serialised JointState (CDR, or ROS 1). Raises BagError when it is not one."""
    try:
        big = not ros1 and payload[1] == 0
        order = ">" if big else "<"
        base = 0 if ros1 else 4
        stamp = 4  # behind the encapsulation header (CDR) or the sequence number (ROS 1)

        def aligned(at: int, size: int) -> int:
            return at if ros1 else base + (at - base + size - 1) // size * size

        def number(at: int) -> int:
            return int(struct.unpack_from(order + "I", payload, at)[0])

        def text(at: int) -> tuple[str, int]:
            at = aligned(at, 4)
            size = number(at)
            raw = payload[at + 4 : at + 4 + size]
            if len(raw) != size:
                raise struct.error("string runs over the end")
            return raw.rstrip(b"\0").decode("utf-8", "replace"), at + 4 + size

        _, at = text(stamp + 8)
        at = aligned(at, 4)
        count = number(at)
        if count > len(payload):
            raise struct.error("more names than bytes")
        at += 4
        names = []
        for _ in range(count):
            name, at = text(at)
            names.append(name)
        fixed = np.ones(len(payload), bool)
        fixed[stamp : stamp + 8] = False
        if ros1:
            fixed[:4] = False  # the header's sequence number
        offsets, counts = [], []
        for _ in FIELDS:
            at = aligned(at, 4)
            n = number(at)
            at += 4
            if n:
                at = aligned(at, 8)
            if at + 8 * n > len(payload):
                raise struct.error("array runs over the end")
            fixed[at : at + 8 * n] = False
            offsets.append(at)
            counts.append(n)
            at += 8 * n
    except (struct.error, IndexError) as error:
        raise BagError(f"a JointState of {len(payload)} bytes is damaged ({error}).") from error
    return Layout(
        tuple(names),
        stamp,
        (offsets[0], offsets[1], offsets[2]),
        (counts[0], counts[1], counts[2]),
        big,
        fixed,
        np.frombuffer(payload, np.uint8),
    )


def _rows(block: Block, which: NDArray[np.int64], length: int) -> NDArray[np.uint8]:
    """The payloads (k, length) of some messages of equal length, as a view where they stand evenly."""
    starts = block.starts[which]
    steps = np.diff(starts)
    if starts.size > 1 and steps[0] > 0 and bool((steps == steps[0]).all()):
        first = block.buffer[starts[0] : starts[-1] + length]
        shape, strides = (starts.size, length), (int(steps[0]), 1)
        view: NDArray[np.uint8] = np.lib.stride_tricks.as_strided(first, shape, strides, writeable=False)
        return view
    gathered: NDArray[np.uint8] = block.buffer[starts[:, None] + np.arange(length)]
    return gathered


class JointStateDecoder:
    """Decodes blocks of one topic; remembers the layouts it has met."""

    def __init__(self, *, ros1: bool) -> None:
        self._ros1 = ros1
        self._layouts: list[Layout] = []
        self.damaged = 0
        """Messages that could not be decoded."""

    def __call__(self, block: Block) -> list[JointStates]:
        """The block's messages, one JointStates a layout, each in the order of the file."""
        decoded = []
        same = block.lengths.size == 0 or bool((block.lengths == block.lengths[0]).all())
        lengths = block.lengths[:1] if same else np.unique(block.lengths)
        for length in lengths:
            left = np.arange(block.lengths.size) if same else np.flatnonzero(block.lengths == length)
            while left.size:
                rows = _rows(block, left, int(length))
                layout = self._layout(rows)
                if layout is None:
                    self.damaged += 1
                    left = left[1:]
                    continue
                here = (rows[:, layout.fixed] == layout.reference[layout.fixed]).all(axis=1)
                if here.all():
                    decoded.append(self._decoded(layout, rows, block.received[left]))
                    break
                decoded.append(self._decoded(layout, rows[here], block.received[left[here]]))
                left = left[~here]
        return decoded

    def _layout(self, rows: NDArray[np.uint8]) -> Layout | None:
        first = rows[0]
        for layout in self._layouts:
            if layout.reference.size == first.size and bool((first == layout.reference)[layout.fixed].all()):
                return layout
        try:
            layout = layout_of(first.tobytes(), ros1=self._ros1)
        except BagError:
            return None
        self._layouts.append(layout)
        return layout

    def _decoded(self, layout: Layout, rows: NDArray[np.uint8], received: NDArray[np.int64]) -> JointStates:
        order = ">" if layout.big_endian else "<"
        stamp = np.ascontiguousarray(rows[:, layout.stamp : layout.stamp + 8]).view(order + "u4")
        stamps = stamp[:, 0].astype(np.int64) * 1_000_000_000 + stamp[:, 1]
        columns = []
        n = len(layout.names)
        for offset, count in zip(layout.offsets, layout.counts, strict=True):
            if count != n or n == 0:
                columns.append(np.full((rows.shape[0], n), np.nan))
                continue
            raw = np.ascontiguousarray(rows[:, offset : offset + 8 * count])
            columns.append(raw.view(order + "f8").astype(np.float64, copy=False))
        return JointStates(received, stamps, layout.names, columns[0], columns[1], columns[2])
