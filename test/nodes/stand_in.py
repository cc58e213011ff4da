"""The robot of somebody else in mid-chirp, under each kind of command, and what must be true of it in the end."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from busy import TOO_BUSY
from rig import JOINT, POSITION_LIMIT, VELOCITY_LIMIT, Rig

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
REST_S, STILL_S = 3.0, 0.3
"""Time in which a joint must have come to rest, and how long it must have stood still to be at rest."""
TRIES = 4
"""A machine that is busy with other things may hold up an exciter for too long before a test has begun."""


def exciting(made: Rig, kind: str, *, robot: dict[str, Any] | None = None, **parameters: Any) -> None:
    """A joint of the robot in mid-chirp."""
    made.robot(**as_robot(kind, robot))
    excited(made, kind, **parameters)


def as_robot(kind: str, more: dict[str, Any] | None = None) -> dict[str, Any]:
    """How a robot is that takes this kind of command."""
    return {**KINDS[kind][0], **(more or {})}


def as_exciter(kind: str, more: dict[str, Any] | None = None) -> dict[str, Any]:
    """The parameters of an exciter that commands in this way."""
    joints = {"command.joints": ["shoulder", JOINT], "limits.state_timeout_s": 1.0}
    return {**joints, **KINDS[kind][1], **(more or {})}


def excited(made: Rig, kind: str, **parameters: Any) -> None:
    """Have a robot that is there brought into mid-chirp."""
    given = as_exciter(kind, parameters)
    for _ in range(TRIES):
        made.exciter(**given)
        made.states.clear()
        refusal = made.start_exciting()
        assert not refusal, refusal
        if made.until("exciting"):
            made.spin(1.3)
            if made.processes["chirp_exciter"].poll() is None and made.state["state"] == "exciting":
                return
        made.processes["chirp_exciter"].terminate()
        assert made.ended("chirp_exciter") is not None
        said = made.output("chirp_exciter")
        assert any(text in said for text in TOO_BUSY), said
        made.log("chirp_exciter").write_text("")
    raise AssertionError(f"the machine is too busy:\n{said}")


def guard_pid(made: Rig) -> int:
    """The process that guards the exciter."""
    parent = made.processes["chirp_exciter"].pid
    children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    assert len(children) == 1, children
    return int(children[0])


def stands(made: Rig, since: float, *, start: float = 0.0) -> np.ndarray:
    """The truth since an instant, of a joint that must have come to rest without leaving its limits."""
    after = inside(made, start)
    after = after[after[:, 0] > since]
    assert at_rest(after), "it still moves"
    return after


def inside(made: Rig, start: float = 0.0) -> np.ndarray:
    """The truth so far, of a joint that must never have left its limits beside one that holds."""
    truth = made.truth()
    assert np.abs(truth[:, 2] - start).max() <= POSITION_LIMIT
    assert np.abs(truth[:, 4]).max() <= VELOCITY_LIMIT
    assert np.abs(truth[:, 1] - truth[0, 1]).max() < 0.02, "the other joint has moved"
    return truth


def at_rest(after: np.ndarray) -> bool:
    """Whether the joint has stood still for a while at the end of this part of the truth."""
    end = after[after[:, 0] > after[-1, 0] - STILL_S] if len(after) else after
    return len(end) > 0 and end[-1, 0] - after[0, 0] > STILL_S and bool(np.abs(end[:, 4]).max() < STOPPED)


def comes_to_rest(made: Rig, since: float, *, start: float = 0.0) -> np.ndarray:
    """The truth since an instant, of a joint that comes to rest after it and never leaves its limits."""
    end = time.monotonic() + REST_S
    while time.monotonic() < end:
        made.spin(0.2)
        truth = inside(made, start)
        if at_rest(truth[truth[:, 0] > since]):
            break
    return stands(made, since, start=start)


def ready(made: Rig, timeout_s: float = 30.0) -> None:
    """Wait until the exciter says that all is there."""
    end = time.monotonic() + timeout_s
    while "all that it needs is there" not in made.output("chirp_exciter"):
        assert time.monotonic() < end, made.output("chirp_exciter")
        made.spin(0.2)
    made.spin(0.5)
