"""What others on the network may do to a run: publish nonsense, other limits, or commands of their own."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import COMMANDS, JOINT, LATCHED, Rig, rig
from sensor_msgs.msg import JointState
from stand_in import TOPIC, ready
from std_msgs.msg import Float64MultiArray, String

pytestmark = pytest.mark.ros
URDF = '<robot name="r"><link name="a"/><link name="b"/><joint name="{joint}" type="{kind}">{limit}</joint></robot>'
NARROW = '<limit lower="-0.02" upper="0.02" velocity="0.05" effort="100"/>'
CUT_OFF = b"\0\1\0\0" + bytes(8) + b"\1\0\0\0" + bytes(4) + b"\5\0\0\0"
"""A joint state that ends where its five names should begin."""


def description(kind: str, limit: str) -> String:
    return String(data=URDF.format(joint=JOINT, kind=kind, limit=limit))


def exciting(made: Rig, **parameters: object) -> None:
    made.simulated_joint()
    made.exciter(**{"limits.state_timeout_s": 1.0, **parameters})
    assert made.start_exciting() == ""
    assert made.until("exciting"), made.output("chirp_exciter")


@pytest.mark.parametrize(
    ("kind", "limit"),
    [
        ("continuous", ""),
        pytest.param("revolute", '<limit effort="10" velocity="0"/>', marks=pytest.mark.campaign),
        pytest.param("revolute", "", marks=pytest.mark.campaign),
    ],
)
def test_a_description_without_limits_is_no_permission(kind: str, limit: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.simulated_joint()
        made.exciter()
        ready(made)
        publisher = made.node.create_publisher(String, "/robot_description", LATCHED)
        publisher.publish(description(kind, limit))
        made.met(publisher)
        made.spin(1.0)
        refusal = made.start_exciting(3.0)
        assert "limits.position_min, limits.position_max, limits.velocity not known" in refusal
        assert made.commands == []


def test_limits_that_come_in_mid_motion_hold_from_then_on_and_a_repetition_is_none(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        publisher = made.node.create_publisher(String, "/robot_description", LATCHED)
        heard: list[String] = []
        made.node.create_subscription(String, "/robot_description", heard.append, LATCHED)
        exciting(made, exit_when_done=False)
        while not heard:
            made.spin(0.1)
        publisher.publish(heard[0])
        made.spin(1.0)
        assert made.state["state"] == "exciting", made.state
        publisher.publish(description("revolute", NARROW))
        assert made.until("aborted"), made.output("chirp_exciter")
        assert made.state["reason"] == "/robot_description has changed"
        made.states.clear()
        made.listen_up()
        before = len(made.commands)
        assert "-0.02 to 0.02 rad" in made.start_exciting(4.0)
        assert len(made.commands) == before


def test_two_masters_are_one_too_many(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made)
        made.node.create_publisher(Float64MultiArray, COMMANDS, 10)
        assert made.ended("chirp_exciter") == 3
        assert f"aborted: rig publishes on {COMMANDS} too" in made.output("chirp_exciter")
        made.states.clear()
        made.exciter()
        assert "only one may command the robot" in made.start_exciting(4.0)


def test_what_is_no_joint_state_ends_the_run_as_any_fault(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made, **{"recording.topics": ["/joint_states", "/robot_description"]})
        publisher = made.node.create_publisher(JointState, "/joint_states", 10)
        made.spin(0.5)
        publisher.publish(CUT_OFF)
        assert made.ended("chirp_exciter") == 3
        said = made.output("chirp_exciter")
        assert "a message on /joint_states is no joint state" in said
        assert "Traceback" not in said
        assert "internal error" not in said
        assert "not in the recording" not in said
        assert made.states[-1] == "aborted"
        assert abs(made.references[-1][2]) == 0.0


def test_a_second_publisher_of_the_joint_is_told_as_that(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made)
        publisher = made.node.create_publisher(JointState, "/joint_states", 10)
        made.spin(0.5)
        message = JointState(name=[JOINT], position=[0.0], velocity=[0.0], effort=[0.0])
        message.header.stamp.sec = int(time.time()) - 100
        publisher.publish(message)
        assert made.ended("chirp_exciter") == 3
        said = made.output("chirp_exciter")
        assert "the joint states' time jumps by -" in said
        assert "/rig and /simulated_joint publish joint states, do two of them know the joint?" in said


def test_a_driver_that_comes_back_with_another_quality_is_heard(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.robot()
        made.exciter(**{"command.joints": ["shoulder", JOINT], "command.topic": TOPIC, "limits.state_timeout_s": 1.0})
        ready(made)
        made.processes["robot"].kill()
        made.spin(1.0)
        made.robot(best_effort=True)
        assert made.start_exciting(30.0) == ""
        assert made.until("exciting"), made.output("chirp_exciter")


def test_a_description_that_is_not_kept_is_no_hindrance_where_all_limits_are_given(tmp_path: Path) -> None:
    limits = {"limits.position_min": -0.4, "limits.position_max": 0.4, "limits.velocity": 2.0}
    given = {"command.joints": ["shoulder", JOINT], "command.topic": TOPIC, "limits.require_urdf": False}
    with rig(tmp_path) as made:
        made.robot(description="volatile")
        assert made.node_appears("robot")
        made.spin(0.5)  # so that the description has gone by
        made.exciter(**given, **{"limits.state_timeout_s": 1.0})
        text = "not kept for those who come later"
        assert text in made.start_exciting(30.0, expected=text)
        made.processes["chirp_exciter"].terminate()
        made.ended("chirp_exciter")
        made.exciter(**given, **limits, **{"limits.state_timeout_s": 1.0})
        assert made.start_exciting() == ""
        assert made.until("moving_to_start")


def test_a_mimic_joint_is_refused_by_name(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.robot(extra='<mimic joint="thumb"/>')
        made.exciter(**{"command.joints": ["shoulder", JOINT], "command.topic": TOPIC})
        text = "joint 'elbow' mimics 'thumb'"
        assert text in made.start_exciting(30.0, expected=text)
        assert np.ptp(made.truth()[:, 2]) == 0.0
