"""Bags of every kind with known contents, written by rosbags and by mcap's own library."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from numpy.typing import NDArray
from rosbags import rosbag1, rosbag2
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.typesys import Stores, get_typestore

START_NS = 1_700_000_000_000_000_000
LATENCY_NS = 250_000
RATE_HZ = 500.0
STORE = get_typestore(Stores.ROS2_JAZZY)
ROS1_STORE = get_typestore(Stores.ROS1_NOETIC)
JOINT_STATE = "sensor_msgs/msg/JointState"

Floats = NDArray[np.float64]


class Message(NamedTuple):
    """One message to be recorded."""

    topic: str
    received_ns: int
    kind: str
    content: Any


def ns(time: float) -> int:
    """Seconds since the start of the bag as its time in ns."""
    return START_NS + round(time * 1e9)


def position(time: Floats) -> Floats:
    """The truth: rad, of no frequency above 12 Hz."""
    return 0.3 * np.sin(2 * np.pi * 1.3 * time) + 0.02 * np.sin(2 * np.pi * 11.7 * time + 0.4)


def effort(time: Floats) -> Floats:
    """The truth: N m, of no frequency above 12 Hz."""
    return 20.0 * np.cos(2 * np.pi * 1.3 * time) + 3.0 * np.sin(2 * np.pi * 9.1 * time)


def header(stamp_ns: int, *, frame: str = "", store: Any = STORE) -> Any:
    """std_msgs/Header."""
    seconds, rest = divmod(stamp_ns, 1_000_000_000)
    stamp = store.types["builtin_interfaces/msg/Time"](seconds, rest)
    kind = store.types["std_msgs/msg/Header"]
    return kind(0, stamp, frame) if store is ROS1_STORE else kind(stamp, frame)


def joint_state(
    stamp_ns: int,
    names: Sequence[str],
    position: Iterable[float] = (),
    effort: Iterable[float] = (),
    *,
    frame: str = "",
    store: Any = STORE,
) -> Any:
    """sensor_msgs/JointState without velocities."""
    arrays = (np.array(list(values), np.float64) for values in (position, (), effort))
    return store.types[JOINT_STATE](header(stamp_ns, frame=frame, store=store), list(names), *arrays)


def swing(samples: int = 2000, *, names: Sequence[str] = ("joint_1", "joint_2"), store: Any = STORE) -> list[Message]:
    """The joint `joint_2` swings along the truth at RATE_HZ, all others are held; stamps and times of reception."""
    time = np.arange(samples) / RATE_HZ
    at, moved, pushed = names.index("joint_2"), position(time), effort(time)
    messages = []
    for i in range(samples):
        q, u = np.full(len(names), 0.5), np.zeros(len(names))
        q[at], u[at] = moved[i], pushed[i]
        stamp = ns(time[i])
        content = joint_state(stamp, names, q, u, store=store)
        messages.append(Message("/joint_states", stamp + LATENCY_NS, JOINT_STATE, content))
    return messages


def rosbag2_bag(
    path: Path,
    messages: Sequence[Message],
    storage: StoragePlugin = StoragePlugin.MCAP,
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """A rosbag2 folder, by rosbags."""
    writer = rosbag2.Writer(path, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, received, kind, content in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            data = content if isinstance(content, bytes) else STORE.serialize_cdr(content, kind)
            writer.write(connections[topic], received, bytes(data))
    return path


def mcap_file(
    path: Path,
    messages: Sequence[Message],
    compression: CompressionType = CompressionType.NONE,
    *,
    chunked: bool = True,
    chunk_size: int = 1 << 16,
    finished: bool = True,
    summary: bool = True,
) -> Path:
    """A bare .mcap file, by mcap's own library; `finished` False: as a crash leaves it, without footer."""
    with path.open("wb") as file:
        writer = McapWriter(
            file,
            compression=compression,
            use_chunking=chunked,
            chunk_size=chunk_size,
            enable_crcs=True,
            use_statistics=summary,
            repeat_channels=summary,
            repeat_schemas=summary,
        )
        writer.start("ros2")
        channels: dict[str, int] = {}
        for topic, received, kind, content in messages:
            if topic not in channels:
                definition, _ = STORE.generate_msgdef(kind, ros_version=2)
                schema = writer.register_schema(kind, "ros2msg", definition.encode())
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            data = content if isinstance(content, bytes) else STORE.serialize_cdr(content, kind)
            writer.add_message(channels[topic], received, bytes(data), received)
        if finished:
            writer.finish()
    return path


def ros1_bag(
    path: Path, messages: Sequence[Message], compression: rosbag1.Writer.CompressionFormat | None = None
) -> Path:
    """A ROS 1 bag, by rosbags; contents are of ROS1_STORE."""
    writer = rosbag1.Writer(path)
    writer.chunk_threshold = 1 << 16
    if compression is not None:
        writer.set_compression(compression)
    with writer:
        connections = {}
        for topic, received, kind, content in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=ROS1_STORE)
            writer.write(connections[topic], received, bytes(ROS1_STORE.serialize_ros1(content, kind)))
    return path


def _folder(storage: StoragePlugin, compression: CompressionMode) -> Callable[[Path, list[Message]], Path]:
    return lambda folder, messages: rosbag2_bag(folder / "bag", messages, storage, compression)


def _file(compression: CompressionType, **options: Any) -> Callable[[Path, list[Message]], Path]:
    return lambda folder, messages: mcap_file(folder / "bag.mcap", messages, compression, **options)


def _ros1(compression: rosbag1.Writer.CompressionFormat | None) -> Callable[[Path, list[Message]], Path]:
    return lambda folder, messages: ros1_bag(folder / "bag.bag", messages, compression)


ROS2_KINDS: dict[str, Callable[[Path, list[Message]], Path]] = {
    "mcap": _folder(StoragePlugin.MCAP, CompressionMode.NONE),
    "mcap, zstd chunks": _folder(StoragePlugin.MCAP, CompressionMode.STORAGE),
    "mcap, file zstd": _folder(StoragePlugin.MCAP, CompressionMode.FILE),
    "mcap, message zstd": _folder(StoragePlugin.MCAP, CompressionMode.MESSAGE),
    "sqlite3": _folder(StoragePlugin.SQLITE3, CompressionMode.NONE),
    "sqlite3, file zstd": _folder(StoragePlugin.SQLITE3, CompressionMode.FILE),
    "sqlite3, message zstd": _folder(StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    "bare mcap, small chunks": _file(CompressionType.NONE),
    "bare mcap, zstd": _file(CompressionType.ZSTD),
    "bare mcap, lz4": _file(CompressionType.LZ4),
    "bare mcap, no chunks": _file(CompressionType.NONE, chunked=False),
    "bare mcap, no summary": _file(CompressionType.ZSTD, summary=False),
}
ROS1_KINDS: dict[str, Callable[[Path, list[Message]], Path]] = {
    "ROS 1": _ros1(None),
    "ROS 1, bz2": _ros1(rosbag1.Writer.CompressionFormat.BZ2),
    "ROS 1, lz4": _ros1(rosbag1.Writer.CompressionFormat.LZ4),
}


def written(folder: Path, kind: str, samples: int = 2000) -> Path:
    """The bag of this kind with the swing of `joint_2` in it."""
    if kind in ROS1_KINDS:
        return ROS1_KINDS[kind](folder, swing(samples, store=ROS1_STORE))
    return ROS2_KINDS[kind](folder, swing(samples))


def data_file(bag: Path) -> Path:
    """The one file of a bag that holds its messages."""
    return next(p for p in sorted(bag.iterdir()) if p.name != "metadata.yaml") if bag.is_dir() else bag
