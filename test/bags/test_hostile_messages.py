"""Message definitions and messages made to keep their reader busy are refused at once, in one line."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from bag_writer import JOINT_STATE, START_NS, STORE, Message, header, joint_state, mcap_file, ns, swing
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from waiting import no_longer_than

from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.commands.check_bag import checked_bag
from flex_ident.errors import FlexIdentError

PART = "\n" + "=" * 80 + "\nMSG: "
OWN = SignalSelection(motor_position="/robot:f0", effort="/robot:f1")
NUMBERS = "float64 f0\nfloat64 f1\n"


def laughs(levels: int, last: str) -> str:
    """The definition of `p/L0`: ten fields of the next type, each of ten of the next, down to `last`."""
    kinds = [*(f"p/L{level + 1}" for level in range(levels - 1)), last]
    return "".join(f"{PART}p/L{i}\n" + "\n".join(f"{kind} f{k}" for k in range(10)) for i, kind in enumerate(kinds))


DEFINITIONS = {
    "fields of fields": f"{NUMBERS}p/L0 rest{laughs(9, 'float64[0]')}",
    "an array of empty messages": f"{NUMBERS}p/E[1000000000] rest{PART}p/E\n",
    "an array of empty arrays": f"{NUMBERS}p/E[1000000000] rest{PART}p/E\nfloat64[0] none",
}


def own_bag(path: Path, definition: str, messages: int = 100, size: int = 404) -> Path:
    """A bag of messages of `size` bytes on /robot, of a type that the bag defines so."""
    with path.open("wb") as file:
        writer = McapWriter(file, compression=CompressionType.NONE)
        writer.start("ros2")
        schema = writer.register_schema("p/msg/A", "ros2msg", definition.encode())
        channel = writer.register_channel("/robot", "cdr", schema)
        for i in range(messages):
            time_ns = START_NS + 2_000_000 * i
            writer.add_message(channel, time_ns, b"\0\1\0\0" + bytes(size - 4), time_ns)
        writer.finish()
    return path


def poses(stamp_ns: int, count: int) -> Any:
    """geometry_msgs/PoseArray of equal poses."""
    kinds = STORE.types
    point, turn = (
        kinds["geometry_msgs/msg/Point"](0.0, 0.0, 0.0),
        kinds["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
    )
    return kinds["geometry_msgs/msg/PoseArray"](
        header(stamp_ns), [kinds["geometry_msgs/msg/Pose"](point, turn)] * count
    )


def refused(bag: Path, selection: SignalSelection | None = None, match: str = "") -> None:
    """Assert that the bag is refused in one short line, in under two seconds of processor time."""
    with no_longer_than(2.0, processor=True), pytest.raises(FlexIdentError, match=match) as caught:
        read_recording(bag, selection)
    assert len(str(caught.value)) < 1000
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", DEFINITIONS)
def test_a_definition_that_multiplies_is_refused(kind: str, tmp_path: Path) -> None:
    refused(own_bag(tmp_path / "bag.mcap", DEFINITIONS[kind]), OWN, "/robot: p/msg/A has more fields than a message")


def test_a_definition_that_multiplies_is_known_without_end(tmp_path: Path) -> None:
    path = ".".join(["f0"] * 12)
    selection = SignalSelection(motor_position=f"/robot:rest.{path}", effort="/robot:f1")
    definition = f"{NUMBERS}p/L0 rest{laughs(12, 'float64')}"
    refused(own_bag(tmp_path / "bag.mcap", definition), selection, "holds no messages")


def test_a_definition_of_many_fields_is_not_gone_through_for_each_message(tmp_path: Path) -> None:
    definition = "\n".join(f"float64 f{i}" for i in range(8000))
    refused(own_bag(tmp_path / "bag.mcap", definition, 20_000, 12), OWN, "holds no messages")


def test_messages_that_never_have_the_same_fields_are_refused(tmp_path: Path) -> None:
    messages = [
        Message("/robot", ns(0.002 * i), "geometry_msgs/msg/PoseArray", poses(ns(0.002 * i), 150 + i % 80))
        for i in range(300)
    ]
    bag = mcap_file(tmp_path / "bag.mcap", messages, CompressionType.ZSTD)
    where = "/robot:poses.0.position"
    selection = SignalSelection(motor_position=f"{where}.x", effort=f"{where}.y")
    refused(bag, selection, "hardly two have the same fields")


def states(names: Callable[[int], list[str]], messages: int, topic: str = "/joint_states") -> list[Message]:
    """Joint states of joints that each move a little; message i has the names of number i."""
    made = []
    for i in range(messages):
        own, stamp = names(i), ns(0.002 * i)
        content = joint_state(stamp, own, [0.1 * (i % 10)] * len(own), [1.0] * len(own))
        made.append(Message(topic, stamp, JOINT_STATE, content))
    return made


NAMES: dict[str, Callable[[int], list[str]]] = {
    "many joints": lambda _: [f"j{n}" for n in range(20_000)],
    "other names in each message": lambda i: [f"j{i}_{n}" for n in range(600)],
    "another order in each message": lambda i: [f"j{(n + i) % 600}" for n in range(600)],
}


@pytest.mark.parametrize("kind", NAMES)
def test_too_many_names_of_joints_are_refused_and_kept_from_no_good_topic(kind: str, tmp_path: Path) -> None:
    bad = states(NAMES[kind], 4 if kind == "many joints" else 40, "/other/joint_states")
    refused(mcap_file(tmp_path / "bag.mcap", bad, CompressionType.ZSTD), match="has over 16384 names of joints")
    good = mcap_file(tmp_path / "good.mcap", [*swing(600), *bad], CompressionType.ZSTD)
    with no_longer_than(2.0, processor=True):
        assert read_recording(good).joint == "joint_2"


def test_many_joints_are_looked_at_together(tmp_path: Path) -> None:
    messages = states(lambda _: [f"j{n}" for n in range(2000)], 40)
    bag = mcap_file(tmp_path / "bag.mcap", messages, CompressionType.ZSTD, chunk_size=1)
    refused(bag, match="and 1976 more")


def test_many_topics_are_listed_in_part(tmp_path: Path) -> None:
    messages = [message for i in range(700) for message in states(lambda _: ["a", "b"], 3, f"/r{i}/joint_states")]
    bag = mcap_file(tmp_path / "bag.mcap", messages, CompressionType.ZSTD)
    refused(bag, match="and 1000 more")
    refused(bag, SignalSelection(joint="c"), "no joint 'c' in /r0/joint_states.* more: it has a")
    refused(bag, SignalSelection(motor_position="/none:a"), "it has /r0/joint_states.* and 676 more")
    page = checked_bag(bag, SignalSelection(motor_position="/none:a"))
    assert "and 444 more" in page
    assert len(page) < 60_000
