"""Nothing goes on moving when the exciter does not: measured on the plant, which knows no timeout of its own."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import JOINT, rig
from stand_in import TOPIC, comes_to_rest, exciting, guard_pid, ready

pytestmark = pytest.mark.ros


def test_the_guard_outlives_the_exciter_and_ends_when_all_is_still(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made, "velocity")
        guard = guard_pid(made)
        at = time.monotonic()
        made.processes["chirp_exciter"].kill()
        made.spin(0.5)
        assert Path(f"/proc/{guard}").exists()
        comes_to_rest(made, at)
        end = time.monotonic() + 15.0
        while Path(f"/proc/{guard}").exists() and Path(f"/proc/{guard}/stat").read_text().split()[2] != "Z":
            assert time.monotonic() < end, "the guard outlives what it guards"
            made.spin(0.1)


@pytest.mark.parametrize("name", ["SIGHUP", pytest.param("SIGTERM", marks=pytest.mark.campaign)])
def test_a_terminal_that_closes_ramps_the_joint_down(name: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made, "velocity")
        at = time.monotonic()
        made.processes["chirp_exciter"].send_signal(getattr(signal, name))
        assert made.ended("chirp_exciter") == 3
        assert f"aborted: stopped by {name}" in made.output("chirp_exciter")
        after = comes_to_rest(made, at)
        assert np.abs(np.diff(after[:, 4])).max() < 0.3, "it was stopped, not ramped down"


def test_the_call_that_starts_says_who_guards(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.robot()
        made.exciter(**{"command.joints": ["shoulder", JOINT], "command.topic": TOPIC})
        ready(made)
        success, message = made.call("/chirp_exciter/start")
        assert success, message
        assert f"process {guard_pid(made)} stops the joint should this node die" in message
