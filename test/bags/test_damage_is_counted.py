"""Damage that no checksum finds is counted against indexes and summaries, and said with numbers."""

import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest
from bag_writer import JOINT_STATE, ROS1_STORE, Message, data_file, joint_state, mcap_file, ns, ros1_bag, swing, written

from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.errors import FlexIdentError
from flex_ident.recording import Recording
from flex_ident.report.sentences import sentence

SAMPLES = 2000


def said(recording: Recording) -> str:
    return " | ".join(sentence(notice) for notice in recording.notices if notice.code == "bag_damaged")


def without_checksums(path: Path) -> bytearray:
    """The bytes of an MCAP file of plain chunks, their checksums set to 0: not known."""
    data, at = bytearray(path.read_bytes()), 8
    while at + 9 < len(data) - 8:
        if data[at] == 6:
            data[at + 33 : at + 37] = bytes(4)
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    return data


def third_message(data: bytearray, chunk: int) -> int:
    """Where the third message of a chunk begins."""
    at = 8
    for _ in range(chunk + 1):
        while data[at] != 6:
            at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
        begin = at + 9 + 28 + 4 + 8
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    at, met = begin, 0
    while True:
        met += data[at] == 5
        if met == 3:
            return at
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")


def opcode_zero(data: bytearray, at: int) -> None:
    data[at] = 0


def length_short(data: bytearray, at: int) -> None:
    data[at + 1 : at + 9] = (3).to_bytes(8, "little")


def length_long(data: bytearray, at: int) -> None:
    data[at + 1 : at + 9] = (1 << 40).to_bytes(8, "little")


def other_channel(data: bytearray, at: int) -> None:
    data[at + 9 : at + 11] = b"\x77\x77"


@pytest.mark.parametrize("damage", [opcode_zero, length_short, length_long, other_channel])
@pytest.mark.parametrize("finished", [True, False])
def test_damage_within_a_chunk_is_counted(
    tmp_path: Path, damage: Callable[[bytearray, int], None], finished: bool
) -> None:
    path = mcap_file(tmp_path / "bag.mcap", swing(SAMPLES), finished=finished)
    data = without_checksums(path)
    damage(data, third_message(data, 1))
    path.write_bytes(data)
    recording = read_recording(path)
    read = recording.sampling[0].samples
    assert read < SAMPLES
    assert f"{read} of" in said(recording)
    assert "messages of /joint_states were read: the others are lost" in said(recording)
    if finished:
        assert f"{read} of {SAMPLES} messages" in said(recording)


@pytest.mark.parametrize("opcode", [9, 10, 15, 2, 0x90, 0, 77])
@pytest.mark.parametrize("finished", [True, False])
def test_a_chunk_that_looks_like_something_else_is_missed(tmp_path: Path, opcode: int, finished: bool) -> None:
    path = mcap_file(tmp_path / "bag.mcap", swing(SAMPLES), finished=finished)
    data = bytearray(path.read_bytes())
    at = 8
    for _ in range(2):
        while data[at] != 6:
            at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
        chunk, at = at, at + 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    data[chunk] = opcode
    path.write_bytes(data)
    recording = read_recording(path)
    read = recording.sampling[0].samples
    assert read < SAMPLES
    assert said(recording)
    if finished:
        assert f"{read} of {SAMPLES} messages of /joint_states were read" in said(recording)
        assert read > SAMPLES // 2  # the chunks behind it were found by the summary


def test_a_summary_that_is_damaged_costs_no_messages(tmp_path: Path) -> None:
    path = mcap_file(tmp_path / "bag.mcap", swing(SAMPLES))
    data = bytearray(path.read_bytes())
    data[-60:-40] = b"\xff" * 20
    path.write_bytes(data)
    assert read_recording(path).sampling[0].samples == SAMPLES


def ros1_damaged(tmp_path: Path, what: bytes, new: bytes, which: int = 5) -> Recording:
    path = ros1_bag(tmp_path / "bag.bag", swing(SAMPLES, store=ROS1_STORE))
    data, at = bytearray(path.read_bytes()), 0
    for _ in range(which):
        at = data.index(what, at + 1)
    data[at : at + len(what)] = new
    path.write_bytes(data)
    return read_recording(path)


@pytest.mark.parametrize(
    ("what", "new"),
    [
        (b"op=\x02", b"op=\x09"), (b"op=\x02", b"op=\x07"), (b"op=\x02", b"xx=\x02"),
        (b"conn=\0\0\0\0", b"conn=\7\0\0\0"),
        (b"op=\x05", b"op=\x04"), (b"op=\x05", b"op=\x63"),
    ],
)  # fmt: skip
def test_damage_within_a_ros1_bag_is_counted(tmp_path: Path, what: bytes, new: bytes) -> None:
    recording = ros1_damaged(tmp_path, what, new, 60 if what in (b"op=\x02", b"conn=\0\0\0\0") else 2)
    read = recording.sampling[0].samples
    assert read < SAMPLES
    assert f"{read} of {SAMPLES} messages of /joint_states were read: the others are lost." in said(recording)


def test_a_ros1_bag_that_was_not_closed_says_so(tmp_path: Path) -> None:
    path = written(tmp_path, "ROS 1", SAMPLES)
    data = bytearray(path.read_bytes())
    at = data.index(b"index_pos=") + 10
    data[at : at + 8] = bytes(8)
    path.write_bytes(data)
    assert [n.code for n in read_recording(path).notices] == ["bag_unfinished"]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("UPDATE messages SET data = 5 WHERE id % 100 = 3", "20 of 2000 messages are damaged"),
        ("UPDATE messages SET timestamp = 'x' WHERE id = 7", "1 of 2000 messages are damaged"),
        ("UPDATE messages SET topic_id = 99 WHERE id < 11", "10 of 2000 messages belong to no topic"),
        ("DELETE FROM messages WHERE id BETWEEN 500 AND 599", "100 of 2000 numbered messages are lost"),
    ],
)
@pytest.mark.parametrize("metadata", [True, False])
def test_rows_that_are_no_messages_are_counted(tmp_path: Path, change: str, text: str, metadata: bool) -> None:
    bag = written(tmp_path, "sqlite3", SAMPLES)
    database = sqlite3.connect(data_file(bag))
    database.execute(change)
    database.commit()
    database.close()
    if not metadata:
        (bag / "metadata.yaml").unlink()
    recording = read_recording(bag)
    read = recording.sampling[0].samples
    assert read < SAMPLES
    assert text in said(recording)
    assert (f"{read} of {SAMPLES} messages of /joint_states were read" in said(recording)) == metadata


@pytest.mark.parametrize("value", [0, 1, 26, 127, 128, 255])
def test_a_row_whose_header_is_damaged_is_missed(tmp_path: Path, value: int) -> None:
    """Sqlite finds some of these out only when it looks at the row, and not when it passes over it."""
    bag = written(tmp_path, "sqlite3", 600)
    (bag / "metadata.yaml").unlink()
    file = data_file(bag)
    whole = file.read_bytes()
    with sqlite3.connect(file) as database:
        (content,) = database.execute("SELECT data FROM messages WHERE id = 300").fetchone()
    at = whole.index(content)
    for before in range(1, 24):
        file.write_bytes(whole[: at - before] + bytes([value]) + whole[at - before + 1 :])
        try:
            recording = read_recording(bag, SignalSelection(joint="joint_2"))
        except FlexIdentError:
            continue
        assert recording.sampling[0].samples == 600 or recording.notices, f"{before} bytes before the message"


def test_rows_of_which_only_the_index_knows_are_counted(tmp_path: Path) -> None:
    """A leaf of the table says that it holds three rows fewer: sqlite sees nothing wrong with it."""
    bag = written(tmp_path, "sqlite3", SAMPLES)
    (bag / "metadata.yaml").unlink()
    file = data_file(bag)
    database = sqlite3.connect(file)
    (size,) = database.execute("PRAGMA page_size").fetchone()
    database.execute("CREATE INDEX IF NOT EXISTS timestamp_idx ON messages (timestamp)")
    database.commit()
    database.close()
    data = bytearray(file.read_bytes())
    leaves = [p for p in range(size, len(data), size) if data[p] == 13 and b"joint_2" in data[p : p + size]]
    page = leaves[len(leaves) // 2]
    data[page + 4] -= 3
    file.write_bytes(data)
    recording = read_recording(bag)
    read = recording.sampling[0].samples
    assert read == SAMPLES - 3
    assert f"{read} of {SAMPLES} messages in its index were read: the others are lost." in said(recording)


def test_a_message_whose_names_are_damaged_is_counted_and_a_second_publisher_is_none(tmp_path: Path) -> None:
    others = [
        Message("/joint_states", ns(0.1 * i), JOINT_STATE, joint_state(ns(0.1 * i), ["gripper"], [0.5], [0.0]))
        for i in range(30)
    ]
    made = sorted([*swing(SAMPLES), *others], key=lambda m: m.received_ns)
    recording = read_recording(mcap_file(tmp_path / "two.mcap", made))
    assert said(recording) == ""
    made[700] = made[700]._replace(content=joint_state(made[700].received_ns, ["joint_1", "joynt_2"], [0, 0], [0, 0]))
    recording = read_recording(mcap_file(tmp_path / "damaged.mcap", made))
    assert said(recording) == "1 messages of /joint_states hold names that no others do: damaged, left out."
