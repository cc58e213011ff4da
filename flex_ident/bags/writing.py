"""Joint states written as a rosbag2."""

from __future__ import annotations

import heapq
import shutil
import struct
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from flex_ident.errors import UsageError
from flex_ident.recording import Floats

JOINT_STATE = "sensor_msgs/msg/JointState"
STORAGE = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
COMPRESSION = {"": CompressionMode.NONE, "file": CompressionMode.FILE, "message": CompressionMode.MESSAGE}
EPOCH_NS = 1_700_000_000_000_000_000
ROWS = 4096
"""Messages that are made together."""
STAMP_AT = 4
"""Where a message that starts with a header holds its stamp: after CDR's four bytes."""


def write_joint_states(
    path: Path, time: Floats, names: Sequence[str], position: Floats, velocity: Floats, effort: Floats, *,
    storage: str = "mcap", topic: str = "/joint_states", compression: str = "",
    more: Mapping[str, tuple[Floats, Sequence[str], Floats]] | None = None,
) -> None:  # fmt: skip
    """Write a rosbag2 folder, replacing one that is there: `time` (n,), s; the others (n, joints) or (n, 0), SI.

    `more` gives further JointState topics with time (m,), names and positions (m, joints) only. `compression` is by
    file, by message or empty. Raises UsageError.
    """
    for what, value, allowed in (("storage", storage, STORAGE), ("compression", compression, COMPRESSION)):
        if value not in allowed:
            raise UsageError(f"{what} is '{value}': expected one of {', '.join(filter(None, allowed))}.")
    channels = {topic: _messages(time, names, position, velocity, effort)}
    for name, (at, joints, positions) in (more or {}).items():
        none = np.zeros((at.size, 0))
        channels[name] = _messages(at, joints, positions, none, none)
    if path.exists():
        if not (path / "metadata.yaml").exists():
            raise UsageError(f"{path} exists and is not a bag: it is not overwritten.")
        shutil.rmtree(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    writer = Writer(path, version=9, storage_plugin=STORAGE[storage])
    writer.set_compression(COMPRESSION[compression], CompressionFormat.ZSTD)
    store = get_typestore(Stores.ROS2_JAZZY)
    with writer:
        connections = {name: writer.add_connection(name, JOINT_STATE, typestore=store) for name in channels}
        rows = (_of_channel(name, messages) for name, messages in channels.items())
        for ns, name, data in heapq.merge(*rows, key=lambda row: row[0]):
            writer.write(connections[name], ns, data)


def _of_channel(name: str, messages: Iterator[tuple[int, bytes]]) -> Iterator[tuple[int, str, bytes]]:
    return ((ns, name, data) for ns, data in messages)


def _messages(
    time: Floats, names: Sequence[str], position: Floats, velocity: Floats, effort: Floats
) -> Iterator[tuple[int, bytes]]:
    """Instant in ns and CDR of each message, in order of time. Raises UsageError when shapes do not fit.

    All are of one length: one is serialised with a mark for every number, and the marks are overwritten.
    """
    n, joints = time.size, len(names)
    fields = (position, velocity, effort)
    for values in fields:
        if values.shape not in ((n, joints), (n, 0)):
            raise UsageError(f"joint states of shape {values.shape}: expected ({n}, {joints}) or ({n}, 0).")
    marks = [1.234567e300 + 1e297 * (i * joints + np.arange(values.shape[1])) for i, values in enumerate(fields)]
    template = np.frombuffer(_serialised(list(names), *marks), np.uint8)
    places = [template.tobytes().index(struct.pack("<d", mark[0])) if mark.size else 0 for mark in marks]
    ns = EPOCH_NS + np.rint(np.asarray(time, np.float64) * 1e9).astype(np.int64)
    order = np.argsort(ns, kind="stable")
    return (
        message
        for first in range(0, n, ROWS)
        for message in _block(template, places, ns, fields, order[first : first + ROWS])
    )


def _block(
    template: NDArray[np.uint8], places: Sequence[int], ns: NDArray[np.int64], fields: Sequence[Floats],
    which: NDArray[np.int64],
) -> Iterator[tuple[int, bytes]]:  # fmt: skip
    """The messages of some rows."""
    data = np.tile(template, (which.size, 1))
    stamps = np.column_stack((ns[which] // 10**9, ns[which] % 10**9)).astype("<i4")
    data[:, STAMP_AT : STAMP_AT + 8] = stamps.view(np.uint8)
    for values, at in zip(fields, places, strict=True):
        if values.shape[1]:
            data[:, at : at + 8 * values.shape[1]] = np.ascontiguousarray(values[which], "<f8").view(np.uint8)
    return ((int(instant), row.tobytes()) for instant, row in zip(ns[which], data, strict=True))


def _serialised(names: list[str], position: Floats, velocity: Floats, effort: Floats) -> bytes:
    store = get_typestore(Stores.ROS2_JAZZY)
    types: Any = store.types
    stamp = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
    message = types[JOINT_STATE](header=header, name=names, position=position, velocity=velocity, effort=effort)
    return bytes(store.serialize_cdr(message, JOINT_STATE))
