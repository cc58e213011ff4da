"""How the situations of `situations.py` are played."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from plant_faults import ALL_KINDS, REFUSED, TIMEOUT_S, PlantFault, Play
from rig import JOINT, LATCHED, POSITION_LIMIT, VELOCITY_LIMIT, Rig
from sensor_msgs.msg import JointState
from stand_in import KINDS, as_exciter, as_robot, excited, exciting

OWN_LIMITS = {
    "limits.position_min": -POSITION_LIMIT, "limits.position_max": POSITION_LIMIT, "limits.velocity": VELOCITY_LIMIT,
    "limits.effort": 60.0,
}  # fmt: skip
WALL = 0.08
"""Where something is in the way, rad, of a start position beyond it."""
SLOW_HZ = 200.0
"""Of commands and joint states where two robots share a machine of two cores."""
LINKS = "/link_joint_states"


SEEN_S = 1.5
"""Time in which the exciter sees joint states before it is asked to start: in less it knows no pace of theirs."""


def refusal(
    reason: str, *, kinds: tuple[str, ...] = ALL_KINDS, robot: dict[str, Any] | None = None, **parameters: Any
) -> PlantFault:
    """A call of ~/start that is refused; a value of `robot` may differ from one kind of command to another."""

    def play(made: Rig, kind: str) -> str:
        more = {key: value[kind] if isinstance(value, dict) else value for key, value in (robot or {}).items()}
        made.robot(**as_robot(kind, more))
        made.exciter(**as_exciter(kind, parameters))
        assert made.node_appears("chirp_exciter")
        made.spin(SEEN_S)
        refused = made.start_exciting(30.0, expected=reason)
        made.spin(0.5)
        return refused

    return PlantFault(play, reason, REFUSED, kinds, still=True)


def not_started(reason: str, arguments: Callable[[Rig], list[str]], robot: dict[str, Any], **given: Any) -> PlantFault:
    """An exciter that ends before it is a node: its configuration is refused."""

    def play(made: Rig, kind: str) -> float:
        made.robot(**as_robot(kind, robot))
        assert made.node_appears("robot")
        made.exciter(arguments(made), **as_exciter(kind, {"auto_start": True, **given}))
        return time.monotonic()

    return PlantFault(play, reason, 2, still=True)


def goes_well(robot: dict[str, Any] | None = None, **parameters: Any) -> Play:
    """A run to its end."""

    def play(made: Rig, kind: str) -> float:
        exciting(made, kind, robot=robot, **parameters)
        return time.monotonic()

    return play


def in_mid_chirp(fault: str, *, robot: dict[str, Any] | None = None, **parameters: Any) -> Play:
    """A fault of the robot in mid-chirp."""

    def play(made: Rig, kind: str) -> float:
        exciting(made, kind, robot=robot, **{"limits.state_timeout_s": TIMEOUT_S, **parameters})
        at = time.monotonic()
        made.set_parameter("robot", "fault", fault)
        return at

    return play


def linked(fault: str) -> Play:
    """A fault of the encoders on the links in mid-chirp, which are recorded."""
    return in_mid_chirp(fault, robot={"links": True}, **{"recording.topics": [LINKS]})


def foreign_section(made: Rig) -> list[str]:
    """A parameter file for the exciter of somebody else."""
    file = made.folder / "parameters.yaml"
    file.write_text("/other/chirp_exciter:\n  ros__parameters:\n    joint: elbow\n")
    return ["--params-file", str(file)]


def relative(kind: str) -> dict[str, str]:
    """Where commands go inside a namespace."""
    return {"command.topic": KINDS[kind][1]["command.topic"].removeprefix("/")}


def in_a_namespace(made: Rig, kind: str) -> float:
    """A chirp that another robot's limits would allow, and those of the robot of this namespace do not."""
    made.robot("other_robot", limit=1.0, speed=6.0)
    made.robot(**as_robot(kind, {"namespace": "/left"}))
    assert made.node_appears("robot")
    given = {**relative(kind), "auto_start": True, "chirp.amplitude": 0.9, "limits.velocity": 6.0}
    made.exciter(["-r", "__ns:=/left"], **as_exciter(kind, given))
    return time.monotonic()


def two_robots(which: str) -> Play:
    """Two robots in mid-chirp, and the readings of one of them stop: of `robot`, or of `other/robot`."""

    def play(made: Rig, kind: str) -> float:
        slow = {"rate_hz": SLOW_HZ}
        made.robot("other_robot", **as_robot(kind, {"namespace": "/other", **slow}))
        others: list[bool] = []
        made.node.create_subscription(
            DiagnosticStatus, "/other/chirp_exciter/state", lambda s: others.append(_excites(s)), LATCHED
        )
        given = {**slow, "limits.state_timeout_s": TIMEOUT_S}
        others_own = {**given, **relative(kind), "auto_start": True, "chirp.duration_s": 30.0}
        made.exciter(["-r", "__ns:=/other"], process="other_exciter", **as_exciter(kind, others_own))
        while not any(others):
            assert made.processes["other_exciter"].poll() is None, made.output("other_exciter")
            made.spin(0.1)
        exciting(made, kind, robot=slow, **given)
        at = time.monotonic()
        made.set_parameter(which, "fault", "stop")
        return at

    return play


def _excites(status: DiagnosticStatus) -> bool:
    return any(v.key == "state" and v.value == "exciting" for v in status.values)


def other_unharmed(made: Rig) -> None:
    """The other robot moves on inside its limits."""
    assert made.processes["other_exciter"].poll() is None, made.output("other_exciter")
    _other_inside(made)


def other_aborted(made: Rig) -> None:
    """The other robot's run has ended for what was wrong with it."""
    assert made.ended("other_exciter") == 3, made.output("other_exciter")
    assert "no joint state for" in made.output("other_exciter")
    _other_inside(made)


def _other_inside(made: Rig) -> None:
    truth = made.truth(robot="other_robot")
    assert 0.05 < np.abs(truth[:, 2]).max() <= POSITION_LIMIT
    assert np.abs(truth[:, 4]).max() <= VELOCITY_LIMIT


def second_publisher(made: Rig, kind: str) -> float:
    """Somebody else says in mid-chirp that all joints stand at zero."""
    exciting(made, kind)
    publisher = made.node.create_publisher(JointState, "/joint_states", 10)
    made.met(publisher)
    made.spin(0.3)
    at = time.monotonic()
    zeros = [0.0, 0.0]
    while made.processes["chirp_exciter"].poll() is None and time.monotonic() < at + 5.0:
        message = JointState(name=["shoulder", JOINT], position=zeros, velocity=zeros, effort=zeros)
        message.header.stamp = made.node.get_clock().now().to_msg()
        publisher.publish(message)
        made.spin(0.01)
    return at


def not_kept(made: Rig, kind: str) -> float:
    """A robot_description that has gone by before the exciter came, all limits given."""
    made.robot(**as_robot(kind, {"description": "volatile"}))
    assert made.node_appears("robot")
    made.spin(0.5)
    excited(made, kind, **{"limits.require_urdf": False, **OWN_LIMITS})
    return time.monotonic()


def started(made: Rig, kind: str, robot: dict[str, Any] | None = None, **parameters: Any) -> float:
    """A call of ~/start that is not refused."""
    made.robot(**as_robot(kind, robot))
    made.exciter(**as_exciter(kind, parameters))
    refused = made.start_exciting(30.0)
    assert not refused, refused
    return time.monotonic()


def never_there(made: Rig, kind: str) -> float:
    """Something is in the way to the start position."""
    started(made, kind, {"wall": WALL}, start_position=0.15, **{"limits.tracking_error": 5.0})
    assert made.until("ramping_down"), made.output("chirp_exciter")
    return time.monotonic()


def frozen_on_the_way(made: Rig, kind: str) -> float:
    """The readings freeze on the way to the start position."""
    started(made, kind, start_position=0.2, **{"limits.state_timeout_s": 0.25})
    made.spin(0.3)
    at = time.monotonic()
    made.set_parameter("robot", "fault", "freeze")
    return at


def robot_killed(made: Rig, kind: str) -> float:
    """The computer of the robot dies in mid-chirp, its drives do not."""
    exciting(made, kind, **{"limits.state_timeout_s": TIMEOUT_S})
    at = time.monotonic()
    made.processes["robot"].kill()
    return at


def identifier_killed(made: Rig, kind: str) -> float:
    """The identifier dies in mid-chirp."""
    made.start("identifier", {"bag_directories": [str(made.folder)]})
    exciting(made, kind)
    os.kill(made.processes["identifier"].pid, signal.SIGKILL)
    return time.monotonic()


def controller_leaves(made: Rig, kind: str) -> float:
    """The controller takes no more commands, and is not there any more; nobody else listens to its topic."""
    robot: dict[str, Any] = {}
    parameters: dict[str, Any] = {}
    if kind == "position":
        robot, parameters = {"controller": "controller"}, {"command.topic": "/controller/commands"}
    exciting(made, kind, robot=robot, **parameters)
    at = time.monotonic()
    made.set_parameter("robot", "fault", "leave")
    return at


def calls_in_disorder(made: Rig, kind: str) -> float:
    """A stop before a start, two starts, a parameter while it moves, a stop."""
    made.robot(**as_robot(kind))
    made.exciter(**as_exciter(kind))
    assert made.until("idle")
    assert made.call("/chirp_exciter/stop") == (False, "nothing to stop: idle.")
    refused = made.start_exciting()
    assert not refused, refused
    success, message = made.call("/chirp_exciter/start")
    assert not success
    assert "already" in message
    assert "call ~/stop first" in made.set_parameter("chirp_exciter", "chirp.amplitude", 0.3)
    assert made.until("exciting"), made.output("chirp_exciter")
    made.spin(1.0)
    at = time.monotonic()
    assert made.call("/chirp_exciter/stop") == (True, "ramping down")
    return at
