"""Nothing goes on moving when the exciter does not: measured on the plant, which knows no timeout of its own."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import JOINT, POSITION_LIMIT, VELOCITY_LIMIT, Rig, rig

pytestmark = pytest.mark.ros
TOPIC = "/forward_position_controller/commands"
KINDS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "position": ({"interface": "position"}, {"command.topic": TOPIC}),
    "velocity": ({"interface": "velocity"}, {"command.topic": TOPIC, "command.interface": "velocity"}),
    "effort": (
        {"interface": "effort"},
        {"command.topic": TOPIC, "command.interface": "effort", "command.position_gain": 300.0,
         "command.velocity_gain": 30.0, "command.hold_position_gains": [300.0], "command.hold_velocity_gains": [30.0]},
    ),
    "trajectory": (
        {"trajectory": True, "controller": "joint_trajectory_controller"},
        {"command.topic": "/joint_trajectory_controller/joint_trajectory", "command.type": "joint_trajectory"},
    ),
}  # fmt: skip
STOPPED = 0.02
"""Speed, rad/s, below which a joint stands still."""


def exciting(made: Rig, kind: str, *, robot: dict[str, Any] | None = None, **parameters: Any) -> None:
    """A joint of the robot in mid-chirp."""
    its, ours = KINDS[kind]
    made.robot(**{**its, **(robot or {})})
    made.exciter(**{"command.joints": ["shoulder", JOINT], **ours, **parameters})
    refusal = made.start_exciting()
    assert not refusal, refusal
    assert made.until("exciting"), made.output("chirp_exciter")
    made.spin(1.3)


def guard_pid(made: Rig) -> int:
    """The process that guards the exciter."""
    parent = made.processes["chirp_exciter"].pid
    children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    assert len(children) == 1, children
    return int(children[0])


def stands(made: Rig, since: float) -> np.ndarray:
    """The truth since an instant, of a joint that must have come to rest without leaving its limits."""
    truth = made.truth()
    assert np.abs(truth[:, 2]).max() <= POSITION_LIMIT
    assert np.abs(truth[:, 4]).max() <= VELOCITY_LIMIT
    assert np.abs(truth[:, 1] - 0.5).max() < 0.02, "the other joint has moved"
    after = truth[truth[:, 0] > since]
    end = after[after[:, 0] > after[-1, 0] - 0.3]
    assert np.abs(end[:, 4]).max() < STOPPED, "it still moves"
    return after


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["SIGKILL", "SIGSTOP"])
def test_the_joint_stops_when_the_exciter_does(kind: str, name: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made, kind)
        guard = guard_pid(made)
        at = time.monotonic()
        made.processes["chirp_exciter"].send_signal(getattr(signal, name))
        made.spin(2.0)
        stands(made, at)
        assert "stops the joint" in made.output("chirp_exciter") or kind in ("position", "trajectory")
        if name == "SIGSTOP":
            made.processes["chirp_exciter"].send_signal(signal.SIGCONT)
            assert made.ended("chirp_exciter") == 3
            assert "this node stood still for" in made.output("chirp_exciter")
            made.spin(0.5)
            stands(made, at)
        end = time.monotonic() + 15.0
        while Path(f"/proc/{guard}").exists() and Path(f"/proc/{guard}/stat").read_text().split()[2] != "Z":
            assert time.monotonic() < end, "the guard outlives what it guards"
            made.spin(0.1)


def test_nothing_moves_without_a_guard_and_its_death_ends_the_motion(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made, "velocity")
        at = time.monotonic()
        os.kill(guard_pid(made), signal.SIGKILL)
        assert made.ended("chirp_exciter") == 3
        assert "the guard, which stops the joint should this node die, has ended" in made.output("chirp_exciter")
        made.spin(0.5)
        stands(made, at)


@pytest.mark.parametrize("name", ["SIGHUP", "SIGTERM"])
def test_a_terminal_that_closes_ramps_the_joint_down(name: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made, "velocity")
        at = time.monotonic()
        made.processes["chirp_exciter"].send_signal(getattr(signal, name))
        assert made.ended("chirp_exciter") == 3
        assert f"aborted: stopped by {name}" in made.output("chirp_exciter")
        made.spin(0.5)
        after = stands(made, at)
        assert np.abs(np.diff(after[:, 4])).max() < 0.3, "it was stopped, not ramped down"


def test_the_call_that_starts_says_who_guards(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.robot()
        made.exciter(**{"command.joints": ["shoulder", JOINT], "command.topic": TOPIC})
        end = time.monotonic() + 20.0
        while "all that it needs is there" not in made.output("chirp_exciter"):
            assert time.monotonic() < end, made.output("chirp_exciter")
            made.spin(0.2)
        made.spin(0.5)
        success, message = made.call("/chirp_exciter/start")
        assert success, message
        assert f"process {guard_pid(made)} stops the joint should this node die" in message
