"""The bag's own thread: never in the way of a command, honest about what was lost."""

import time
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from flex_ident.errors import BagError
from flex_ident.nodes import bag_file
from flex_ident.nodes.bag_file import BagFile, unique_folder

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPE = "std_msgs/msg/String"
DEFINITION, DIGEST = STORE.generate_msgdef(TYPE, ros_version=2)[0], STORE.hash_rihs01(TYPE)


def opened(folder: Path, **more: object) -> BagFile:
    given = {"storage": "mcap", "information": {"who": "test"}, "least_free": 1, **more}
    return BagFile(folder, **given)  # type: ignore[arg-type]


def message(k: int) -> bytes:
    return bytes(STORE.serialize_cdr(STORE.types[TYPE](data=f"message {k}"), TYPE))


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_what_is_written_is_read(storage: str, tmp_path: Path) -> None:
    bag = opened(tmp_path / "bag", storage=storage)
    bag.add_topic("/a", TYPE, DEFINITION, DIGEST)
    for k in range(3000):
        bag.write("/a", 10**9 + k, message(k))
        if k == 1500:
            bag.add_topic("/b", TYPE, DEFINITION, DIGEST)
            bag.write("/b", 10**9, message(-1))
            time.sleep(0.6)
    bag.close()
    assert (bag.failure, bag.lost, bag.messages) == ("", 0, 3001)
    with AnyReader([bag.path]) as reader:
        rows = [(c.topic, t, bytes(raw)) for c, t, raw in reader.messages()]
    assert [(t, raw) for topic, t, raw in rows if topic == "/a"] == [(10**9 + k, message(k)) for k in range(3000)]
    assert ("/b", 10**9, message(-1)) in rows


def test_a_disk_without_room_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r"MiB needed: make room, or lower recording\.least_free_mib"):
        opened(tmp_path / "bag", least_free=2**60)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(BagError, match="cannot be written"):
        opened(tmp_path / "file" / "bag")


@pytest.mark.slow
def test_a_disk_that_hangs_holds_up_nobody_and_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bag_file, "STUCK_S", 0.3)
    monkeypatch.setattr(bag_file, "MOST_WAITING", 100)
    bag = opened(tmp_path / "bag")
    monkeypatch.setattr(bag_file, "flush_storage", lambda _storage: time.sleep(1.5))
    bag.add_topic("/a", TYPE, DEFINITION, DIGEST)
    began, longest, failure = time.monotonic(), 0.0, ""
    for k in range(1200):
        before = time.monotonic()
        bag.write("/a", k, message(k))
        longest = max(longest, time.monotonic() - before)
        failure = failure or bag.failure
        time.sleep(0.001)
    assert time.monotonic() - began > 1.0
    assert longest < 0.2
    assert "hangs" in failure
    assert bag.lost > 0
    bag.close()
    assert bag.messages + bag.lost == 1200


def test_a_write_that_fails_ends_the_recording_and_keeps_what_there_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = opened(tmp_path / "bag")
    bag.add_topic("/a", TYPE, DEFINITION, DIGEST)
    bag.write("/a", 1, message(1))
    time.sleep(0.6)

    def full(_storage: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(bag_file, "flush_storage", full)
    time.sleep(0.6)
    assert "failed (No space left on device)" in bag.failure
    bag.write("/a", 2, message(2))
    assert bag.lost == 1
    bag.close()
    with AnyReader([bag.path]) as reader:
        assert [t for _, t, _ in reader.messages()] == [1]


def test_recordings_of_one_second_do_not_meet(tmp_path: Path) -> None:
    first = unique_folder(tmp_path, "a")
    first.mkdir()
    assert unique_folder(tmp_path, "a") == tmp_path / "a_1"
