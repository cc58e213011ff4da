"""Files of tiny records without end are refused at once, wherever those stand."""

import struct
from pathlib import Path

import pytest
from bag_writer import written
from waiting import no_longer_than

from flex_ident.bags.mcap import McapFile
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.commands.check_bag import bag_check
from flex_ident.errors import BagError, FlexIdentError

pytest.importorskip("backports.zstd")
from backports import zstd
from hostile_bags import MAGIC, chunk, record, text

HEAD = MAGIC + record(1, text("ros2") + text(""))
MANY = 300_000
METADATA, INDEX, MESSAGE = 12, 7, 5
ZERO_BYTES = struct.pack("<HIQQ", 1, 0, 0, 0)
"""A message of no bytes, of a channel that is not described."""
LOOSE = {"metadata": (METADATA, b""), "indexes": (INDEX, b""), "messages": (MESSAGE, ZERO_BYTES)}


def header(fields: dict[bytes, bytes]) -> bytes:
    parts = [name + b"=" + value for name, value in fields.items()]
    return b"".join(struct.pack("<I", len(part)) + part for part in parts)


def ros1_record(fields: dict[bytes, bytes]) -> bytes:
    head = header(fields)
    return struct.pack("<I", len(head)) + head + struct.pack("<I", 0)


def refused(bag: Path) -> None:
    with no_longer_than(2.0, processor=True), pytest.raises(BagError, match="tiny records in"):
        read_recording(bag)


@pytest.mark.parametrize("kind", LOOSE)
def test_tiny_records_outside_of_chunks_are_refused(kind: str, tmp_path: Path) -> None:
    opcode, body = LOOSE[kind]
    bag = tmp_path / "bag.mcap.zstd"
    bag.write_bytes(zstd.compress(HEAD + MANY * record(opcode, body)))
    refused(bag)


def test_tiny_records_within_chunks_are_refused(tmp_path: Path) -> None:
    short = 100_000 * record(MESSAGE, b"")
    bag = tmp_path / "bag.mcap"
    bag.write_bytes(HEAD + 3 * chunk(zstd.compress(short), "zstd", len(short)))
    refused(bag)


def test_tiny_records_of_ros1_are_refused(tmp_path: Path) -> None:
    bag = tmp_path / "bag.bag.zstd"
    bag.write_bytes(zstd.compress(b"#ROSBAG V2.0\n" + 80_000 * ros1_record({b"op": b"\4"})))
    refused(bag)


def test_a_summary_that_names_chunks_backwards_is_sorted_once(tmp_path: Path) -> None:
    count = 160_000
    chunks = record(METADATA, bytes([6]) * count)  # each byte could begin a chunk
    body = HEAD + chunks + record(15, bytes(4))
    first = len(HEAD) + 9
    index = b"".join(record(8, struct.pack("<QQQ", 0, 0, first + i)) for i in reversed(range(count)))
    bag = tmp_path / "bag.mcap"
    bag.write_bytes(body + index + record(2, struct.pack("<QQI", len(body), 0, 0)) + MAGIC)
    with no_longer_than(2.0, processor=True), pytest.raises(FlexIdentError, match="no joint_states topic"):
        read_recording(bag)


@pytest.mark.parametrize("kind", ["bare mcap, no chunks", "bare mcap, small chunks", "ROS 1"])
def test_a_recording_in_small_records_is_read(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flex_ident.bags.mcap.FREE_RECORDS", 0)
    monkeypatch.setattr("flex_ident.bags.ros1.FREE_RECORDS", 0)
    bag = written(tmp_path, kind)
    assert read_recording(bag).time.size == 2000


def test_a_file_without_a_topic_is_walked_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    walks = []
    stretches = McapFile._stretches
    monkeypatch.setattr(McapFile, "_stretches", lambda self: walks.append(self) or stretches(self))
    bag = tmp_path / "bag.mcap"
    bag.write_bytes(HEAD + MANY * record(INDEX, struct.pack("<HI", 0, 0)) + record(METADATA, b"")[:-1])
    page, error = bag_check(bag, SignalSelection())
    assert len(walks) == 1
    assert "damage: bag.mcap" in page
    assert "it has no topic" in str(error)
