"""Bags made to hurt are refused in one line, soon, and in little memory; nothing stays behind."""

import os
import re
import signal
import sqlite3
import struct
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import pytest
from bag_writer import (
    JOINT_STATE,
    Message,
    data_file,
    joint_state,
    mcap_file,
    ns,
    position,
    rosbag2_bag,
    swing,
    written,
)
from rosbags.rosbag2 import StoragePlugin

from flex_ident.bags import read_recording
from flex_ident.bags.storage import Bag
from flex_ident.errors import BagError, FlexIdentError
from flex_ident.report.sentences import sentence

zstd: Any = pytest.importorskip("backports.zstd")
ZEROS = bytes(1 << 26)
MAGIC = b"\x89MCAP0\r\n"


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def chunk(packed: bytes, compression: str, size: int) -> bytes:
    body = struct.pack("<QQQI", 0, 0, size, 0) + text(compression) + struct.pack("<Q", len(packed)) + packed
    return record(6, body)


def bomb(path: Path, packed: bytes, compression: str, size: int, times: int = 1) -> Path:
    path.write_bytes(MAGIC + record(1, text("ros2") + text("")) + times * chunk(packed, compression, size))
    return path


def zstd_zeros(mebibytes: int) -> bytes:
    packer = zstd.ZstdCompressor()
    return b"".join(packer.compress(bytes(1 << 20)) for _ in range(mebibytes)) + packer.flush()


def lz4_zeros(mebibytes: int) -> bytes:
    packer = lz4.frame.LZ4FrameCompressor()
    return packer.begin() + b"".join(packer.compress(bytes(1 << 20)) for _ in range(mebibytes)) + packer.flush()


def sqlite_file(path: Path, messages: str) -> Path:
    database = sqlite3.connect(path)
    database.execute("CREATE TABLE topics (id INTEGER, name TEXT, type TEXT)")
    database.execute("INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState')")
    database.execute(messages)
    database.commit()
    database.close()
    return path


ENDLESS = (
    "CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
    "SELECT i AS id, 1 AS topic_id, i AS timestamp, zeroblob(1000000) AS data FROM n"
)
COMPUTED = (
    "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
    "data BLOB AS (zeroblob(100000000)))"
)
HOSTILE: dict[str, Callable[[Path], Path]] = {
    "zstd, 4 GiB announced": lambda p: bomb(p / "a.mcap", zstd_zeros(4096), "zstd", 4 << 30),
    "zstd, 1 MiB announced": lambda p: bomb(p / "a.mcap", zstd_zeros(4096), "zstd", 1 << 20),
    "zstd, 128 MiB announced, 400 times": lambda p: bomb(p / "a.mcap", zstd_zeros(128), "zstd", 128 << 20, 400),
    "lz4, 4 GiB announced": lambda p: bomb(p / "a.mcap", lz4_zeros(4096), "lz4", 4 << 30),
    "lz4, 128 MiB announced, 40 times": lambda p: bomb(p / "a.mcap", lz4_zeros(128), "lz4", 128 << 20, 40),
    "2^63 bytes announced": lambda p: bomb(p / "a.mcap", b"", "", 1 << 63),
    "empty frames": lambda p: bomb(p / "a.mcap", zstd.compress(b"") * 500_000, "zstd", 1 << 20),
    "whole file": lambda p: (p / "a.mcap.zstd").write_bytes(zstd_zeros(4096)) and p / "a.mcap.zstd",
    "whole file within a file": lambda p: (p / "a.mcap.zstd").write_bytes(zstd.compress(zstd_zeros(100))) and p,
    "empty schemas": lambda p: bomb(p / "a.mcap", zstd.compress(record(3, b"\0\0") * 5_000_000), "zstd", 55_000_000),
    "view": lambda p: sqlite_file(p / "a.db3", ENDLESS),
    "computed": lambda p: sqlite_file(p / "a.db3", COMPUTED),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_bag_is_refused_in_two_seconds_and_300_mib(name: str, tmp_path: Path) -> None:
    path = HOSTILE[name](tmp_path)
    script = """
        import sys, time
        from pathlib import Path
        from flex_ident.bags import read_recording
        from flex_ident.errors import FlexIdentError
        started = time.process_time()
        try:
            read_recording(Path(sys.argv[1]))
        except FlexIdentError as error:
            print(f"refused: {error}")
        peak = Path("/proc/self/status").read_text().partition("VmHWM:")[2].split()[0]  # not that of pytest
        print(time.process_time() - started, int(peak) / 1024)
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), str(path)], capture_output=True, text=True, check=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )  # fmt: skip
    said, measured = run.stdout.strip().rsplit("\n", 1)
    seconds, mebibytes = map(float, measured.split())
    assert said.startswith("refused: ")
    assert "\n" not in said
    assert seconds < 2.0
    assert mebibytes < 300.0
    assert [p.name for p in tmp_path.iterdir()] == [path.name if path != tmp_path else "a.mcap.zstd"]


@pytest.mark.parametrize("storage", list(StoragePlugin))
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_a_signal_leaves_nothing_in_the_temporary_folder(
    storage: StoragePlugin, number: signal.Signals, tmp_path: Path
) -> None:
    bag, temporary = written(tmp_path, f"{storage.name.lower()}, file zstd", 300), tmp_path / "temporary"
    temporary.mkdir()
    script = "import sys, time; from pathlib import Path; from flex_ident.bags.storage import Bag\n"
    script += "bag = Bag(Path(sys.argv[1])); print(len(bag.topics()), flush=True); time.sleep(60)"
    run = subprocess.Popen(
        [sys.executable, "-c", script, str(bag)], stdout=subprocess.PIPE, env={**os.environ, "TMPDIR": str(temporary)}
    )
    assert run.stdout is not None
    assert run.stdout.readline() == b"1\n"
    run.send_signal(number)
    run.wait(10)
    run.stdout.close()
    assert list(temporary.iterdir()) == []


def test_a_pipe_or_a_device_is_no_bag(tmp_path: Path) -> None:
    pipe = tmp_path / "bag.mcap"
    os.mkfifo(pipe)
    for path in (pipe, Path("/dev/zero")):
        started = time.perf_counter()
        with pytest.raises(BagError, match="is a pipe or a device"):
            read_recording(path)
        assert time.perf_counter() - started < 1.0
    with pytest.raises(BagError, match="holds no bag"):
        read_recording(tmp_path)
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: {relative_file_paths: [bag.mcap]}\n")
    with pytest.raises(BagError, match="is a pipe or a device"):
        read_recording(tmp_path)


@pytest.mark.parametrize("storage", list(StoragePlugin))
def test_a_path_that_is_not_utf8_is_read_and_shown(storage: StoragePlugin, tmp_path: Path) -> None:
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/b\xffg\x1b[2J\n"))
    os.rename(rosbag2_bag(tmp_path / "bag", swing(600), storage), folder)
    recording = read_recording(folder)
    assert recording.path.encode() == os.fsencode(tmp_path) + "/b\\xffg\N{REPLACEMENT CHARACTER}[2J".encode() + (
        "\N{REPLACEMENT CHARACTER}".encode()
    )
    with pytest.raises(FlexIdentError) as caught:
        read_recording(folder / "gone\x07.mcap")
    assert str(caught.value).isprintable()


def test_control_characters_in_names_are_harmless(tmp_path: Path) -> None:
    messages = [
        Message("/joint_states", ns(0.002 * i), JOINT_STATE,
                joint_state(ns(0.002 * i), ["joint\x1b[31m\n", "b\u202ecd"], [float(position(0.002 * i)), 0.0]))
        for i in range(300)
    ]  # fmt: skip
    messages += [message._replace(topic="/other\x1b]0;x\x07") for message in messages]
    for kind in (mcap_file(tmp_path / "bag.mcap", messages), rosbag2_bag(tmp_path / "bag", messages,
                 StoragePlugin.SQLITE3)):  # fmt: skip
        with Bag(kind) as bag:
            assert all(topic.name.isprintable() for topic in bag.topics())
        with pytest.raises(FlexIdentError) as caught:
            read_recording(kind)
        assert str(caught.value).isprintable()


def test_metadata_that_cannot_be_read_is_said(tmp_path: Path) -> None:
    bag = written(tmp_path, "mcap", 600)
    for content, said in (
        ("a: &a [*a]", "alias"), ("[" * 100_000, "deep|depth"), ("\udcff", "UTF-8"), ("a: 1", "describes no bag"),
        ("rosbag2_bagfile_information: {message_count: 1" + "0" * 400 + "}", "401 digits"),
    ):  # fmt: skip
        (bag / "metadata.yaml").write_text(content, errors="surrogateescape")
        recording = read_recording(bag)
        assert recording.time.size == 600
        assert [n.code for n in recording.notices] == ["bag_damaged"]
        assert "metadata.yaml" in sentence(recording.notices[0])
        assert re.search(said, sentence(recording.notices[0]))
    assert data_file(bag).exists()
