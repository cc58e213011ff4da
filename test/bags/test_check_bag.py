"""The page that `flex_ident check-bag` prints."""

import re
from pathlib import Path

import numpy as np
import pytest
from bag_writer import (
    JOINT_STATE,
    LATENCY_NS,
    RATE_HZ,
    Message,
    data_file,
    joint_state,
    ns,
    rosbag2_bag,
    swing,
    written,
)

from flex_ident.bags.selection import SignalSelection
from flex_ident.commands.check_bag import bag_check, checked_bag
from flex_ident.errors import BagError, ExcitationError, SignalError


def test_page_names_topics_joints_and_sampling(tmp_path: Path) -> None:
    messages = [m for i, m in enumerate(swing(6000)) if i % 500 != 17 and not 3000 <= i < 3020]
    text, error = bag_check(rosbag2_bag(tmp_path / "bag", messages), SignalSelection())
    assert error is None
    lines = {line.split("  ")[1].strip(): line for line in text.splitlines() if line.startswith("  ")}
    assert "sensor_msgs/msg/JointState  5969 messages" in text
    assert "joint_1  5969 messages  held" in text
    assert "joint_2  5969 messages  moved 0.6" in text
    for expected in ("/joint_states:joint_2.effort", "500.00 Hz", "header", "0.52 %", "42 ms"):
        assert expected in lines["motor torque"]
    assert re.search(r"12 s; moves 0\.6\d* at 1\.\d to 12 Hz; effort from -2\d", text)
    assert "no link position: the model of the motor alone" in text
    assert "[gaps]" in text
    assert "can be identified" in text


@pytest.mark.slow
def test_link_encoder_is_seen_with_its_skew(tmp_path: Path) -> None:
    messages = swing(3000)
    for i in range(3000):
        stamp = ns(i / RATE_HZ + 3e-4)
        content = joint_state(stamp, ["joint_2"], [0.3 * np.sin(i / 70)])
        messages.append(Message("/link_joint_states", stamp + LATENCY_NS, JOINT_STATE, content))
    messages.sort(key=lambda m: m.received_ns)
    text, error = bag_check(rosbag2_bag(tmp_path / "bag", messages), SignalSelection(joint="joint_2"))
    assert error is None
    assert "both positions" in text
    link = next(line for line in text.splitlines() if line.startswith("  link position  "))
    assert "0.3 ms" in link


def test_each_joint_that_moves_is_looked_at(tmp_path: Path) -> None:
    messages = [
        Message(
            "/joint_states", ns(i / RATE_HZ), JOINT_STATE, joint_state(ns(i / RATE_HZ), ["a", "b"], [q, 2 * q], [q, 0])
        )
        for i, q in enumerate(np.sin(np.arange(1000) / 30))
    ]
    bag = rosbag2_bag(tmp_path / "bag", messages)
    text, error = bag_check(bag, SignalSelection())
    assert error is None  # a can be, b cannot
    assert "joint b cannot be identified: /joint_states:b.effort is zero throughout" in text
    _, error = bag_check(bag, SignalSelection(joint="b"))
    assert isinstance(error, SignalError)


def test_other_joints_that_moved_are_no_plain_yes(tmp_path: Path) -> None:
    q = np.sin(np.arange(6000) / 30) + 0.5 * np.sin(np.arange(6000) / 11)
    messages = [
        Message(
            "/joint_states", ns(i / RATE_HZ), JOINT_STATE,
            joint_state(ns(i / RATE_HZ), ["a", "b"], [q[i], q[i // 2]], [q[i] + 0.3, 1.0]),
        )
        for i in range(q.size)
    ]  # fmt: skip
    text, _ = bag_check(rosbag2_bag(tmp_path / "bag", messages), SignalSelection(joint="a"))
    assert "can be identified only where the motion of other joints hardly loads this one: record it alone" in text


def test_bag_without_motion_or_joints_says_so(tmp_path: Path) -> None:
    still = [m._replace(content=joint_state(m.received_ns, ["a"], [1.0], [2.0])) for m in swing(200)]
    text, error = bag_check(rosbag2_bag(tmp_path / "still", still), SignalSelection())
    assert isinstance(error, ExcitationError)
    assert "cannot be identified: no joint moved" in text
    renamed = [m._replace(topic="/states") for m in swing(200)]
    text, error = bag_check(rosbag2_bag(tmp_path / "other", renamed), SignalSelection(joint="elbow"))
    assert isinstance(error, SignalError)
    assert "no joint 'elbow' in /states: it has joint_1 (0), joint_2 (0." in text


@pytest.mark.slow
def test_what_is_short_slow_or_lost_is_no_plain_yes(tmp_path: Path) -> None:
    text, error = bag_check(rosbag2_bag(tmp_path / "short", swing(150)), SignalSelection())
    assert isinstance(error, ExcitationError)
    assert "150 samples (0.3 s at 500 Hz) are too short" in text
    assert "can be identified," not in text
    text, error = bag_check(rosbag2_bag(tmp_path / "slow", swing(10_000)[::10]), SignalSelection())
    assert error is None
    assert "slow: 50 Hz shows modes below 5 Hz only" in text
    assert "can be identified only in part: see the 1 line above" in text
    once = swing(6000)
    twice = [m._replace(content=once[i - (i % 3 == 1)].content) for i, m in enumerate(once)]
    text, _ = bag_check(rosbag2_bag(tmp_path / "twice", twice), SignalSelection())
    assert "33 % of the messages of the motor position were dropped" in text
    assert "[duplicate_stamps]" in text


@pytest.mark.slow
def test_damage_is_told(tmp_path: Path) -> None:
    bag = written(tmp_path, "bare mcap, small chunks", 3000)
    bag.write_bytes(bag.read_bytes()[: bag.stat().st_size // 2])
    text = checked_bag(bag, SignalSelection())
    assert "damage: bag.mcap is cut at byte" in text
    assert re.search(r"sensor_msgs/msg/JointState  1\d\d\d messages", text)
    assert "part of the bag is lost" in text
    data_file(bag).write_text("text")
    with pytest.raises(BagError, match="is neither"):
        checked_bag(bag, SignalSelection())


def test_one_tone_is_told_before_anything_is_trusted(tmp_path: Path) -> None:
    messages = [
        Message("/joint_states", ns(i / RATE_HZ), JOINT_STATE, joint_state(ns(i / RATE_HZ), ["a"], [q], [2.0 * q]))
        for i, q in enumerate(np.sin(np.arange(6000) / 30))
    ]
    text, _ = bag_check(rosbag2_bag(tmp_path / "bag", messages), SignalSelection(joint="a"))
    assert "one frequency or one speed only, by the warning below" in text
    assert "and little else" in text
