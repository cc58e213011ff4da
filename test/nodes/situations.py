"""What else may be around a run: wrong settings, others on the network, slow or odd joint states, things in the way.

As `plant_faults.py`: under each kind of command, measured on the joints.
"""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from plant_faults import ALL_KINDS, PLANT_FAULTS, REFUSED, TIMEOUT_S, PlantFault, Play
from rig import JOINT, LATCHED, POSITION_LIMIT, VELOCITY_LIMIT, Rig
from sensor_msgs.msg import JointState
from stand_in import KINDS, as_exciter, as_robot, excited, exciting

FORWARD = ("position", "velocity", "effort")
STAYS = ("position", "trajectory")
"""Kinds whose last command leaves a joint where it is: what ends a robot's driver or controller ends no other one."""
OTHER_INTERFACE = {"position": "velocity", "velocity": "position", "effort": "velocity"}
OWN_LIMITS = {
    "limits.position_min": -POSITION_LIMIT, "limits.position_max": POSITION_LIMIT, "limits.velocity": VELOCITY_LIMIT,
    "limits.effort": 60.0,
}  # fmt: skip
PASSIVE = "".join(
    f'<joint name="{name}">{interface}<state_interface name="position"/></joint>'
    for name, interface in (("shoulder", '<command_interface name="position"/>'), (JOINT, ""))
)
NEAR_THE_WRAP = math.pi - 0.02
WITHOUT_END = {"kind": "continuous", "wraps": True, "positions": [0.5, NEAR_THE_WRAP]}
AROUND_THE_WRAP = {"limits.position_min": NEAR_THE_WRAP - 0.4, "limits.position_max": NEAR_THE_WRAP + 0.4}
WALL = 0.08
"""Where something is in the way, rad, of a start position beyond it."""
SLOW_HZ = 200.0
"""Of commands and joint states where two robots share a machine of two cores."""
LINKS = "/link_joint_states"


def refusal(
    reason: str, *, kinds: tuple[str, ...] = ALL_KINDS, robot: dict[str, Any] | None = None, **parameters: Any
) -> PlantFault:
    """A call of ~/start that is refused; a value of `robot` may differ from one kind of command to another."""

    def play(made: Rig, kind: str) -> str:
        more = {key: value[kind] if isinstance(value, dict) else value for key, value in (robot or {}).items()}
        made.robot(**as_robot(kind, more))
        made.exciter(**as_exciter(kind, parameters))
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


SETTINGS = {
    "command.joints in another order than the controller's": refusal(
        "in that order, command.joints holds elbow, shoulder", kinds=FORWARD, **{"command.joints": [JOINT, "shoulder"]}
    ),
    "a trajectory's joints in another order": PlantFault(
        goes_well(**{"command.joints": [JOINT, "shoulder"]}), "", 0, ("trajectory",)
    ),
    "command.joints left empty": PlantFault(goes_well(**{"command.joints": []}), "", 0),
    "command.joints lacks a joint": refusal(
        "in that order, command.joints holds elbow", kinds=FORWARD, **{"command.joints": [JOINT]}
    ),
    "command.joints lacks a joint, allow_partial_joints_goal false": refusal(
        "allow_partial_joints_goal is false", kinds=("trajectory",), **{"command.joints": [JOINT]}
    ),
    "command.joints lacks a joint, allow_partial_joints_goal true": PlantFault(
        goes_well({"partial": True}, **{"command.joints": [JOINT]}), "", 0, ("trajectory",)
    ),
    "a controller of another interface": refusal(
        ", command.interface is ", kinds=FORWARD, robot={"interface": OTHER_INTERFACE}
    ),
    "a parameter file of which no section applies": not_started("no section applies to /", foreign_section, {}),
    "use_sim_time, no /clock": not_started("use_sim_time is true", lambda _: [], {}, use_sim_time=True),
    "use_sim_time, /clock at half of real time": not_started(
        "use_sim_time is true", lambda _: [], {"pace": 0.5, "clock": True}, use_sim_time=True
    ),
    "too little room on the disk": refusal("MiB needed: make room", **{"recording.least_free_mib": 1e6}),
    "a start position outside the limits": refusal("cannot be reached", start_position=1.0),
}  # fmt: skip
"""What is wrong with what was asked for; or only looks so."""
SURROUNDINGS = {
    "another robot's limits are larger than those of the namespace": PlantFault(
        in_a_namespace, "allowed are -0.4 to 0.4 rad", still=True
    ),
    "two robots, the readings of this one stop": PlantFault(
        two_robots("robot"), "no joint state for", after=other_unharmed
    ),
    "two robots, the readings of the other one stop": PlantFault(two_robots("other/robot"), "", 0, after=other_aborted),
    "a second publisher says that all joints are at zero": PlantFault(second_publisher, "publish joint states, do two"),
    "nobody takes the commands": refusal("nobody listens on /nobody", **{"command.topic": "/nobody"}),
    "the controller leaves": PlantFault(controller_leaves, "nobody listens on", kinds=STAYS),
    "kill -9 of the robot's driver and controllers": PlantFault(robot_killed, "no joint state for", kinds=STAYS),
    "kill -9 of the identifier": PlantFault(identifier_killed, "", 0),
    "robot_description is not kept, all limits are given": PlantFault(not_kept, "", 0),
    "a stop before the start, two starts, a stop": PlantFault(calls_in_disorder, "stopped by ~/stop"),
}
"""Who else is there, or is not."""
READINGS = {
    "the driver comes back with another quality of service": PlantFault(in_mid_chirp("other_quality"), "", 0),
    "the readings thin out from 500 to 10 Hz": PlantFault(
        in_mid_chirp("thin"), "/joint_states has thinned out", 0, ("position", "velocity", "trajectory")
    ),
    "the readings that an effort is closed over thin out to 10 Hz": PlantFault(
        in_mid_chirp("thin"), "the joint states have thinned out", kinds=("effort",)
    ),
    "a recorded topic thins out from 500 to 10 Hz": PlantFault(linked("link_thin"), f"{LINKS} has thinned out", 0),
    "a recorded topic stops": PlantFault(linked("link_stop"), f"{LINKS} has stopped", 0),
    "a recorded topic freezes": PlantFault(linked("link_freeze"), f"{LINKS} has frozen", 0),
    "the joint states never carry an effort": refusal("hold no effort of 'elbow'", robot={"efforts": False}),
    "joint states at 50 Hz for a chirp up to 30 Hz": refusal(
        "a chirp up to 30 Hz needs", robot={"rate_hz": 50.0}, **{"chirp.end_frequency_hz": 30.0}
    ),
    "the readings are 0.55 s old from the start, 0.5 s allowed": refusal(
        "old when they come, 0.50 s allowed", robot={"age_s": 0.55}, **{"limits.state_timeout_s": 0.5}
    ),
    "the readings are 0.55 s old from the start, 0.6 s allowed": PlantFault(
        goes_well({"age_s": 0.55}, **{"limits.state_timeout_s": TIMEOUT_S}), "", 0, STAYS
    ),
    "the readings that a loop is closed over are 0.55 s old, 0.6 s allowed": refusal(
        "closed over them",
        kinds=("velocity", "effort"),
        robot={"age_s": 0.55},
        **{"limits.state_timeout_s": TIMEOUT_S},
    ),
    "a simulator at half of real time": refusal("time passes at 0.50 of real time", robot={"pace": 0.5}),
    "a simulator's clock steps back": PlantFault(in_mid_chirp("time_back", robot={"pace": 1.0}), "time jumps by -"),
}
"""What the joint states are like, and what else is recorded."""
JOINTS = {
    "a mimic joint": refusal("joint 'elbow' mimics 'thumb'", robot={"extra": '<mimic joint="thumb"/>'}),
    "a passive joint": refusal("it is passive", robot={"beside": f"<ros2_control>{PASSIVE}</ros2_control>"}),
    "a joint without end, its reading wraps": PlantFault(
        goes_well(WITHOUT_END, **AROUND_THE_WRAP), "", 0, ("velocity", "effort")
    ),
    "a joint without end, positions commanded across a half turn": refusal(
        "turns without end and the motion passes a half turn", kinds=STAYS,
        robot=WITHOUT_END, **AROUND_THE_WRAP,
    ),
    "the joint stands outside its limits": refusal("move it inside", robot={"positions": [0.5, 0.6]}),
    "a start position that is never reached": PlantFault(never_there, "was not reached"),
    "the readings freeze on the way to the start": PlantFault(frozen_on_the_way, "frozen"),
}  # fmt: skip
"""What the joint is like, and where."""
SITUATIONS: dict[str, PlantFault] = {**SETTINGS, **SURROUNDINGS, **READINGS, **JOINTS}
JOINT_FAULTS = {**PLANT_FAULTS, **SITUATIONS}
