"""Speed and memory of reading an hour-long bag, against rosbags deserialising each message, measured in one run.

    python bench/bag_reading.py

The bags (3.6 million JointStates of 7 joints: an hour at 1 kHz) are written once and kept in the temporary folder.
Each figure comes from a fresh process, on a warm cache: messages a second of wall time, and the peak of its memory.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

JOINTS = tuple(f"joint_{i + 1}" for i in range(7))
RATE_HZ = 1000
START_NS = 1_700_000_000_000_000_000
STORE = get_typestore(Stores.ROS2_JAZZY)
KINDS = {
    "mcap": (StoragePlugin.MCAP, CompressionMode.NONE),
    "mcap, zstd": (StoragePlugin.MCAP, CompressionMode.STORAGE),
    "sqlite3": (StoragePlugin.SQLITE3, CompressionMode.NONE),
}
READERS = ("rosbags, each message deserialised", "flex_ident, all joints decoded", "flex_ident, to one recording")


def payloads(first: int, count: int) -> NDArray[np.uint8]:
    """Serialised JointStates (count, bytes) from message `first` on: all joints swing, with a sensor's noise."""
    kind = STORE.types
    empty = np.zeros(len(JOINTS))
    stamp = kind["builtin_interfaces/msg/Time"](0, 0)
    header = kind["std_msgs/msg/Header"](stamp, "base")
    template = bytes(
        STORE.serialize_cdr(
            kind["sensor_msgs/msg/JointState"](header, list(JOINTS), empty, empty, empty), "sensor_msgs/msg/JointState"
        )
    )
    rows = np.tile(np.frombuffer(template, np.uint8), (count, 1))
    index = first + np.arange(count)
    stamps = START_NS + index * (1_000_000_000 // RATE_HZ)
    rows[:, 4:12] = np.stack((stamps // 10**9, stamps % 10**9), axis=1).astype("<u4").view(np.uint8).reshape(count, 8)
    seconds = index[:, None] / RATE_HZ
    random = np.random.default_rng(first)
    phase = 2 * np.pi * 0.7 * seconds + np.arange(len(JOINTS))
    numbers = 8 * len(JOINTS)
    at = len(template)
    for values in (10 * np.sin(phase), 0.4 * np.cos(phase), 0.1 * np.sin(phase)):  # effort, velocity, position
        measured = np.round(values + 1e-3 * random.standard_normal(values.shape), 6)
        rows[:, at - numbers : at] = measured.view(np.uint8).reshape(count, numbers)
        at -= numbers + 8  # the count of the array in front, and its padding
    return rows


def written(folder: Path, kind: str, messages: int) -> Path:
    """The bag of this kind, written unless a whole one is there."""
    path = folder / f"{kind.replace(', ', '_')}_{messages}"
    if (path / "metadata.yaml").exists():
        return path
    storage, compression = KINDS[kind]
    print(f"writing {path}", file=sys.stderr)
    writer = Writer(path, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=STORE)
        for first in range(0, messages, 50_000):
            block = payloads(first, min(50_000, messages - first))
            for i, row in enumerate(block):
                writer.write(connection, START_NS + (first + i) * (1_000_000_000 // RATE_HZ) + 150_000, row.tobytes())
    return path


def deserialised(path: Path, most: int) -> int:
    """Count of messages that rosbags deserialised."""

    def numbers() -> Iterator[float]:
        with AnyReader([path]) as reader:
            for connection, _, data in islice(reader.messages(), most):
                yield reader.deserialize(data, connection.msgtype).position[2]

    return np.fromiter(numbers(), np.float64).size


def measured(reader: str, path: Path, most: int) -> dict[str, float]:
    """Messages, seconds and peak memory, MiB, of one reader in this process."""
    from flex_ident.bags.motions import joint_motions
    from flex_ident.bags.reading import read_recording
    from flex_ident.bags.selection import SignalSelection

    before = time.perf_counter()
    if reader == READERS[0]:
        messages = deserialised(path, most)
    elif reader == READERS[1]:
        messages = joint_motions(path)[0].messages
    else:
        messages = read_recording(path, SignalSelection(joint="joint_3")).sampling[0].samples
    seconds = time.perf_counter() - before
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"messages": messages, "seconds": seconds, "peak_mib": peak}


def main() -> None:
    """Write the bags, measure each reader on each in a process of its own, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--messages", type=int, default=3_600_000)
    parser.add_argument("--deserialised", type=int, default=100_000, help="messages that rosbags is timed on")
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "flex_ident_bench_bags")
    parser.add_argument("--measure", nargs=2, metavar=("READER", "BAG"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        reader, bag = arguments.measure
        print(json.dumps(measured(reader, Path(bag), arguments.deserialised)))
        return
    arguments.folder.mkdir(parents=True, exist_ok=True)
    print("| bag | reader | messages | messages/s | times rosbags | peak MiB |\n| --- | --- | --- | --- | --- | --- |")
    for kind in KINDS:
        bag = written(arguments.folder, kind, arguments.messages)
        for file in sorted(bag.iterdir()):  # a warm cache for all
            with file.open("rb") as handle:
                while handle.read(1 << 24):
                    pass
        slow = 0.0
        for reader in READERS:
            command = [sys.executable, __file__, "--measure", reader, str(bag)]
            command += ["--deserialised", str(arguments.deserialised)]
            found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            rate = found["messages"] / found["seconds"]
            slow = slow or rate
            print(
                f"| {kind} | {reader} | {found['messages']:,} | {rate:,.0f} | {rate / slow:.1f} | "
                f"{found['peak_mib']:.0f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
