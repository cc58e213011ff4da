"""Thirty topics at 300 Hz beside a busy process: commands go on, nothing hangs, and what got lost is said."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import JOINT, rig
from rosbags.highlevel import AnyReader
from stand_in import TOPIC

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.campaign]
TOPICS, RATE_HZ = 30, 300
BUSY = "while True: sum(range(10000))"


def test_many_fast_topics_hold_nothing_up(tmp_path: Path) -> None:
    names = [f"/many_{k}" for k in range(TOPICS)]
    with rig(tmp_path) as made:
        made.robot()
        script = str(Path(__file__).parent / "many_topics.py")
        for name, command in (
            ("many", [sys.executable, script, str(TOPICS), str(RATE_HZ)]), ("busy", [sys.executable, "-c", BUSY])
        ):  # fmt: skip
            with made.log(name).open("ab") as out:
                made.processes[name] = subprocess.Popen(command, stdout=out, stderr=out)
        made.exciter(**{
            "command.joints": ["shoulder", JOINT], "command.topic": TOPIC, "limits.state_timeout_s": 1.0,
            "recording.topics": names, "chirp.duration_s": 6.0,
        })  # fmt: skip
        assert made.start_exciting(30.0) == ""
        assert made.ended("chirp_exciter", 60.0) == 0, made.output("chirp_exciter")
        said = made.output("chirp_exciter")
        bag = made.bag()
    with AnyReader([bag]) as reader:
        numbers = {
            c.topic: [int(reader.deserialize(raw, c.msgtype).data) for _, _, raw in reader.messages([c])]
            for c in reader.connections
            if c.topic in names
        }
    assert set(numbers) == set(names)
    gaps = sum(n[-1] - n[0] + 1 - len(n) for n in numbers.values())
    lost = int(re.search(r", (\d+) lost", said)[1])
    assert lost >= gaps, "messages are missing that were not counted"
    assert sum(map(len, numbers.values())) > 0.5 * TOPICS * RATE_HZ * 6.0
