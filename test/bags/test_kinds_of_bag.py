"""Every kind of bag gives the same numbers; of a damaged one what is whole is read, and what is lost is said."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from bag_writer import (
    JOINT_STATE,
    RATE_HZ,
    ROS1_KINDS,
    ROS1_STORE,
    ROS2_KINDS,
    START_NS,
    data_file,
    effort,
    mcap_file,
    position,
    rosbag2_bag,
    swing,
    written,
)
from mcap.writer import Writer
from rosbags.rosbag2 import StoragePlugin

from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.errors import FlexIdentError, SignalError
from flex_ident.recording import Recording
from flex_ident.report.sentences import sentence

INFORMATION = "rosbag2_bagfile_information:"
KINDS = [*ROS2_KINDS, *ROS1_KINDS]


def assert_true(recording: Recording, *, first: int = 0) -> None:
    """The recording is the truth's samples from `first` on, to the last bit but those of time."""
    time = (first + np.arange(recording.time.size)) / RATE_HZ
    np.testing.assert_allclose(recording.motor_position, position(time), atol=1e-12)
    np.testing.assert_allclose(recording.motor_torque, effort(time), atol=1e-12)
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ, rel=1e-9)


def codes(recording: Recording) -> list[str]:
    return [notice.code for notice in recording.notices]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_numbers_are_those_recorded(tmp_path: Path, kind: str) -> None:
    recording = read_recording(written(tmp_path, kind))
    assert recording.joint == "joint_2"
    assert recording.time.size == 2000
    assert_true(recording)
    assert codes(recording) == []
    assert {s.clock for s in recording.sampling} == {"header"}
    assert recording.start_time_s == pytest.approx(START_NS * 1e-9, abs=1e-6)


@pytest.mark.parametrize("kind", ["mcap", "mcap, file zstd", "mcap, message zstd", "sqlite3", "sqlite3, message zstd"])
def test_metadata_is_not_needed(tmp_path: Path, kind: str) -> None:
    bag = written(tmp_path, kind, 600)
    (bag / "metadata.yaml").unlink()
    for path in (bag, data_file(bag)):
        recording = read_recording(path)
        assert recording.time.size == 600
        assert_true(recording)


@pytest.mark.parametrize(
    "content", ["", "a: [", f"{INFORMATION} 3", f"{INFORMATION}\n  relative_file_paths: [gone.mcap]"]
)
def test_damaged_metadata_does_no_harm(tmp_path: Path, content: str) -> None:
    bag = written(tmp_path, "mcap", 600)
    (bag / "metadata.yaml").write_text(content)
    assert_true(read_recording(bag))


@pytest.mark.parametrize("storage", list(StoragePlugin))
@pytest.mark.parametrize("metadata", [True, False])
def test_split_bag_is_read_in_order(tmp_path: Path, storage: StoragePlugin, metadata: bool) -> None:
    messages = swing(2400)
    whole = tmp_path / "whole"
    whole.mkdir()
    names = []
    for i in range(12):  # twelve: by name, part 10 comes before part 2
        part = rosbag2_bag(tmp_path / f"part_{i}", messages[200 * i : 200 * (i + 1)], storage)
        file = data_file(part)
        names.append(f"whole_{i}{file.suffix}")
        shutil.move(file, whole / names[-1])
    if metadata:
        listed = "".join(f"\n  - {name}" for name in names)
        (whole / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  relative_file_paths:{listed}\n")
    recording = read_recording(whole)
    assert recording.time.size == 2400
    assert_true(recording)
    assert codes(recording) == []


def test_part_that_is_missing_is_named(tmp_path: Path) -> None:
    messages = swing(1200)
    whole = tmp_path / "whole"
    whole.mkdir()
    shutil.move(data_file(rosbag2_bag(tmp_path / "part", messages[:600])), whole / "whole_0.mcap")
    (whole / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  relative_file_paths: [whole_0.mcap, whole_1.mcap]\n"
    )
    recording = read_recording(whole)
    assert recording.time.size == 600
    assert [sentence(n) for n in recording.notices] == ["whole_1.mcap of the bag is missing."]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_bag_cut_at_half_gives_its_first_half(tmp_path: Path, kind: str) -> None:
    bag = written(tmp_path, kind, 4000)
    file = data_file(bag)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    recording = read_recording(bag)
    assert 600 < recording.time.size < 3500
    assert_true(recording)
    assert "bag_damaged" in codes(recording)
    said = sentence(recording.notices[0])
    assert "lost" in said
    assert "100.0 %" not in said  # of a file of one chunk the half before the cut was read


def test_lost_messages_are_counted(tmp_path: Path) -> None:
    bag = written(tmp_path, "sqlite3", 4000)
    file = data_file(bag)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    recording = read_recording(bag)
    text = f"{recording.time.size} of 4000 messages of /joint_states were read: the others are lost."
    assert text in [sentence(n) for n in recording.notices]


@pytest.mark.parametrize("chunked", [True, False])
def test_unfinished_mcap_reads_to_its_end(tmp_path: Path, chunked: bool) -> None:
    whole = mcap_file(tmp_path / "whole.mcap", swing(), chunked=chunked)
    crashed = mcap_file(tmp_path / "crashed.mcap", swing(), chunked=chunked, finished=False)
    assert crashed.stat().st_size < whole.stat().st_size
    recording = read_recording(crashed)
    assert_true(recording)
    assert recording.time.size == 2000 if not chunked else 1500 < recording.time.size <= 2000
    assert "bag_unfinished" in codes(recording) or "bag_damaged" in codes(recording)


def test_unfinished_ros1_bag_reads_to_its_end(tmp_path: Path) -> None:
    bag = written(tmp_path, "ROS 1")
    data = bag.read_bytes()
    index = int.from_bytes(data[data.index(b"index_pos=") + 10 :][:8], "little")
    bag.write_bytes(data[:index].replace(index.to_bytes(8, "little"), bytes(8)))
    recording = read_recording(bag)
    assert recording.time.size == 2000
    assert_true(recording)


def test_chunk_that_fails_its_checksum_is_left_out(tmp_path: Path) -> None:
    bag = written(tmp_path, "bare mcap, small chunks")
    data = bytearray(bag.read_bytes())
    data[data.index(b"joint_2", len(data) // 2) + 200] ^= 0xFF
    bag.write_bytes(data)
    recording = read_recording(bag)
    assert "was left out" in sentence(recording.notices[0])
    assert "gaps" in codes(recording)
    assert recording.measured is not None
    np.testing.assert_allclose(
        recording.motor_position[recording.measured], position(recording.time)[recording.measured], atol=1e-4
    )


def test_killed_recorder_leaves_its_newest_messages_in_the_log(tmp_path: Path) -> None:
    """sqlite3 in write-ahead mode: what is not yet in the file stands in the log beside it."""
    import sqlite3

    bag = written(tmp_path, "sqlite3", 600)
    database = sqlite3.connect(data_file(bag))
    database.execute("PRAGMA journal_mode = WAL")
    database.execute("PRAGMA wal_autocheckpoint = 0")
    rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id DESC LIMIT 300").fetchall()
    database.execute("DELETE FROM messages WHERE id > 300")
    database.commit()
    database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    database.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", rows[::-1])
    database.commit()
    copy = tmp_path / "copy"
    shutil.copytree(bag, copy)
    database.close()
    assert_true(recording := read_recording(copy))
    assert recording.time.size == 600


def outcome(path: Path) -> str:
    """What reading gives: a recording, or the one line that says why not."""
    try:
        return f"{read_recording(path, SignalSelection(joint='joint_2')).time.size} samples"
    except FlexIdentError as error:
        return str(error)


@pytest.mark.parametrize("kind", KINDS)
def test_no_damage_raises_anything_else(tmp_path: Path, kind: str) -> None:
    """Cuts and flipped bytes at random places: a recording, or an error that is one line."""
    random = np.random.default_rng(len(kind))
    bag = written(tmp_path, kind, 300)
    file = data_file(bag)
    whole = file.read_bytes()
    said = set()
    for trial in range(12):
        data = bytearray(whole)
        if trial % 3 == 0:
            del data[int(random.integers(1, len(data))) :]
        else:
            for at in random.integers(0, len(data), 1 + 4 * (trial % 3)):
                data[at] = int(random.integers(256))
        file.write_bytes(data)
        said.add(outcome(bag))
    assert len(said) > 1
    assert not any("\n" in text for text in said)


def test_folder_with_a_part_that_is_no_bag(tmp_path: Path) -> None:
    bag = written(tmp_path, "mcap", 600)
    (bag / "metadata.yaml").unlink()
    (bag / "zzz.mcap").write_text("not a bag")
    recording = read_recording(bag)
    assert recording.time.size == 600
    assert "zzz.mcap: is neither" in sentence(recording.notices[0])


@pytest.mark.parametrize("storage", list(StoragePlugin))
def test_type_that_nothing_defines_is_refused(tmp_path: Path, storage: StoragePlugin) -> None:
    bag = rosbag2_bag(tmp_path / "bag", swing(300), storage)
    file = data_file(bag)
    damaged = file.read_bytes().replace(b"sensor_msgs/msg/JointState", b"sensor_msgs/msg/JointStuff")
    file.write_bytes(damaged.replace(b"std_msgs/Header header", b"std_msgs/Headxx header"))
    selection = SignalSelection(motor_position="/joint_states:position.0", effort="/joint_states:effort.0")
    with pytest.raises(SignalError, match="JointStuff, which neither ROS nor the bag defines"):
        read_recording(bag, selection)


def test_metadata_file_stands_for_its_folder(tmp_path: Path) -> None:
    assert_true(read_recording(written(tmp_path, "mcap", 600) / "metadata.yaml"))


def test_ros1_bag_converted_to_mcap(tmp_path: Path) -> None:
    """`mcap convert` keeps the serialisation and the type names of ROS 1."""
    path = tmp_path / "converted.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros1")
        definition, _ = ROS1_STORE.generate_msgdef(JOINT_STATE, ros_version=1)
        schema = writer.register_schema("sensor_msgs/JointState", "ros1msg", definition.encode())
        channel = writer.register_channel("/joint_states", "ros1", schema)
        for message in swing(600, store=ROS1_STORE):
            data = bytes(ROS1_STORE.serialize_ros1(message.content, JOINT_STATE))
            writer.add_message(channel, message.received_ns, data, message.received_ns)
        writer.finish()
    assert_true(read_recording(path))
