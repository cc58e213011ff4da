"""Bags made to hurt are refused in one line and in little memory; nothing stays behind.

How long that takes is measured by bench/hostile.py.
"""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

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

from flex_ident.bags.reading import read_recording
from flex_ident.bags.storage import Bag
from flex_ident.errors import BagError, FlexIdentError
from flex_ident.report.sentences import sentence

pytest.importorskip("backports.zstd")
from hostile_bags import HOSTILE, refusal


@pytest.mark.slow
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_bag_is_refused_in_one_line_and_300_mib(name: str, tmp_path: Path) -> None:
    path = HOSTILE[name](tmp_path)
    refused = refusal(path)
    assert refused.said
    assert "\n" not in refused.said
    assert refused.mebibytes < 300.0
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
        with pytest.raises(BagError, match="is a pipe or a device"):
            read_recording(path)
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
