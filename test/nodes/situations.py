"""What else may be around a run: wrong settings, others on the network, slow or odd joint states, things in the way.

As `plant_faults.py`: under each kind of command, measured on the joints. `situation_plays.py` has the plays.
"""

from __future__ import annotations

import math

from plant_faults import PLANT_FAULTS, TIMEOUT_S, PlantFault
from rig import JOINT
from situation_plays import (
    LINKS,
    calls_in_disorder,
    controller_leaves,
    foreign_section,
    frozen_on_the_way,
    goes_well,
    identifier_killed,
    in_a_namespace,
    in_mid_chirp,
    linked,
    never_there,
    not_kept,
    not_started,
    other_aborted,
    other_unharmed,
    refusal,
    robot_killed,
    second_publisher,
    two_robots,
)

FORWARD = ("position", "velocity", "effort")
STAYS = ("position", "trajectory")
"""Kinds of command under which a joint stays where it is when nobody commands it any more."""
OTHER_INTERFACE = {"position": "velocity", "velocity": "position", "effort": "velocity"}
PASSIVE = "".join(
    f'<joint name="{name}">{interface}<state_interface name="position"/></joint>'
    for name, interface in (("shoulder", '<command_interface name="position"/>'), (JOINT, ""))
)
NEAR_THE_WRAP = math.pi - 0.02
WITHOUT_END = {"kind": "continuous", "wraps": True, "positions": [0.5, NEAR_THE_WRAP]}
AROUND_THE_WRAP = {"limits.position_min": NEAR_THE_WRAP - 0.4, "limits.position_max": NEAR_THE_WRAP + 0.4}

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
