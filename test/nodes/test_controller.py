"""What the controller is, is asked: wrong orders refused before the first command, open ones filled in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import JOINT, rig
from stand_in import KINDS, TOPIC, exciting

from flex_ident.excitation.motions import FIRST_MOTION

pytestmark = pytest.mark.ros
CONFIG = Path(__file__).resolve().parents[2] / "config"


@pytest.mark.parametrize(
    ("kind", "robot", "given", "text"),
    [
        ("position", {}, {"command.joints": [JOINT, "shoulder"]}, "in that order, command.joints holds elbow"),
        pytest.param(
            "velocity", {}, {"command.interface": "position"}, "command.interface is position",
            marks=pytest.mark.campaign,
        ),
        ("trajectory", {}, {"command.joints": [JOINT]}, "command.joints lacks shoulder"),
        pytest.param(
            "position", {"controlled": ["shoulder"]}, {"command.joints": [JOINT]}, "and not 'elbow'",
            marks=pytest.mark.campaign,
        ),
    ],
)  # fmt: skip
def test_a_mismatch_is_refused_and_nothing_moves(
    kind: str, robot: dict[str, Any], given: dict[str, Any], text: str, tmp_path: Path
) -> None:
    with rig(tmp_path) as made:
        its, ours = KINDS[kind]
        made.robot(**{**its, **robot})
        made.exciter(**{"command.joints": ["shoulder", JOINT], **ours, **given})
        assert text in made.start_exciting(30.0, expected=text)
        made.spin(0.5)
        truth = made.truth()
        assert np.abs(truth[:, 1:3] - truth[0, 1:3]).max() == 0.0


@pytest.mark.parametrize("kind", ["position", pytest.param("trajectory", marks=pytest.mark.campaign)])
def test_joints_that_are_left_open_are_filled_in(kind: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made, kind, **{"command.joints": []})
        truth = made.truth()
        assert np.ptp(truth[:, 2]) > 0.1
        assert np.ptp(truth[:, 1]) < 0.01, "the other joint has moved"


def test_the_shipped_configuration_moves_a_trajectory_controller_of_several_joints(tmp_path: Path) -> None:
    content = yaml.safe_load((CONFIG / "ros2_control.yaml").read_text())
    shipped = {**content["/**"]["ros__parameters"], **content["/**/chirp_exciter"]["ros__parameters"]}
    with rig(tmp_path) as made:
        joints = ["joint_1", "joint_2", "joint_3"]
        made.robot(trajectory=True, controller="joint_trajectory_controller", joints=joints, controlled=joints,
                   positions=[0.5, 0.0, -0.3], limit=1.0)  # fmt: skip
        flat = {
            f"{group}.{key}": value for group in ("command", "chirp", "limits") for key, value in shipped[group].items()
        }
        flat |= {"joint": shipped["joint"], "rate_hz": shipped["rate_hz"], "limits.state_timeout_s": 1.0}
        made.exciter(**{**flat, "chirp.duration_s": 3.0, "chirp.start_frequency_hz": 0.5})
        assert made.start_exciting() == ""
        assert made.ended("chirp_exciter") == 0, made.output("chirp_exciter")
        truth = made.truth(joints=3)
        assert np.ptp(truth[:, 2]) > 0.1
        assert np.ptp(truth[:, [1, 3]], axis=0).max() < 0.01


def test_an_inactive_controller_is_found_out_by_a_first_small_motion(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.robot(active=False)
        made.exciter(**{"command.joints": ["shoulder", JOINT], "command.topic": TOPIC, "limits.state_timeout_s": 1.0})
        assert made.start_exciting() == ""
        assert made.ended("chirp_exciter") == 3
        assert "the joint does not follow" in made.output("chirp_exciter")
        assert "is the controller active" in made.output("chirp_exciter")
        assert "exciting" not in made.states
        assert made.largest_command() <= FIRST_MOTION + 1e-4


def test_an_inactive_controller_is_refused_where_its_manager_says_so(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.robot(active=False, manager=True)
        made.exciter(**{"command.joints": ["shoulder", JOINT], "command.topic": TOPIC, "limits.state_timeout_s": 1.0,
                        "chirp.duration_s": 2.0})  # fmt: skip
        assert made.until("idle")
        made.spin(1.5)  # a controller manager says it once a second
        said = "/forward_position_controller is inactive, as its controller manager says: activate it, then call again."
        assert made.start_exciting(30.0, expected="is inactive") == said
        made.spin(0.5)
        truth = made.truth()
        assert np.abs(truth[:, 1:3] - truth[0, 1:3]).max() == 0.0
        assert made.set_parameter("robot", "fault", "none") == ""
        assert made.start_exciting(10.0) == ""
        assert made.ended("chirp_exciter") == 0, made.output("chirp_exciter")


@pytest.mark.parametrize("from_desired", [False, True])
def test_a_controller_whose_feedback_is_in_the_commands_is_told(from_desired: bool, tmp_path: Path) -> None:
    its, ours = KINDS["trajectory"]
    with rig(tmp_path) as made:
        made.robot(**its, from_desired=from_desired)
        made.exciter(**{"command.joints": ["shoulder", JOINT], "limits.state_timeout_s": 1.0, **ours,
                        "chirp.duration_s": 2.0})  # fmt: skip
        assert made.start_exciting() == ""
        assert made.ended("chirp_exciter") == 0, made.output("chirp_exciter")
        assert ("interpolate_from_desired_state is false" in made.output("chirp_exciter")) != from_desired
