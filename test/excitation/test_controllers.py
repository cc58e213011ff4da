"""What a controller's own parameters say against commands, without ROS."""

import pytest

from flex_ident.excitation.activity import Activity
from flex_ident.excitation.controllers import Controller

FORWARD = Controller("/forward", ("a", "b"), "position")
TRAJECTORY = Controller("/trajectory", ("a", "b"), None, partial=False)
PARTIAL = Controller("/trajectory", ("a", "b"), None, partial=True)


@pytest.mark.parametrize(
    ("controller", "kind", "interface", "joint", "joints", "text"),
    [
        (FORWARD, "forward_command", "position", "b", ["a", "b"], ""),
        (FORWARD, "forward_command", "position", "b", [], ""),
        (FORWARD, "forward_command", "position", "b", ["b", "a"], "in that order, command.joints holds b, a"),
        (FORWARD, "forward_command", "position", "b", ["b"], "in that order, command.joints holds b"),
        (FORWARD, "forward_command", "velocity", "b", [], "takes commands of position, command.interface is velocity"),
        (FORWARD, "forward_command", "position", "c", [], "commands a, b, and not 'c'"),
        (TRAJECTORY, "joint_trajectory", "position", "b", ["b", "a"], ""),
        (TRAJECTORY, "joint_trajectory", "position", "b", ["b"], "command.joints lacks a"),
        (TRAJECTORY, "joint_trajectory", "position", "b", ["b", "c"], "does not command c"),
        (PARTIAL, "joint_trajectory", "position", "b", ["b"], ""),
    ],
)
def test_commands_that_do_not_suit_are_refused(
    controller: Controller, kind: str, interface: str, joint: str, joints: list[str], text: str
) -> None:
    why = controller.objection(kind, interface, joint, joints)
    assert text in why
    assert bool(why) == bool(text)


def test_joints_that_are_left_open_are_filled_in() -> None:
    assert FORWARD.completed("forward_command", "b", []) == ["a", "b"]
    assert TRAJECTORY.completed("joint_trajectory", "b", []) == ["a", "b"]
    assert PARTIAL.completed("joint_trajectory", "b", []) == ["b"]
    assert FORWARD.completed("forward_command", "b", ["b", "a"]) == ["b", "a"]


@pytest.mark.parametrize(("from_desired", "told"), [(None, False), (True, False), (False, True)])
def test_feedback_in_the_commands_is_told_of_trajectories_alone(from_desired: bool | None, told: bool) -> None:
    controller = Controller("/trajectory", ("a",), None, False, from_desired)
    assert ("interpolate_from_desired_state" in controller.advice("joint_trajectory")) == told
    assert controller.advice("forward_command") == ""


@pytest.mark.parametrize("key", ["arm", "arm.state"])
def test_a_controller_is_inactive_as_long_as_its_manager_says_so(key: str) -> None:
    activity, status = Activity(), "controller_manager: Controllers Activity"
    assert activity.objection(0.0, ["/left/arm"]) == ""
    activity.hear(1.0, status, {key: "inactive", "broadcaster": "active"})
    assert "/left/arm is inactive" in activity.objection(2.0, ["/left/arm"])
    assert activity.objection(2.0, ["/left/other", "/left/broadcaster"]) == ""
    assert activity.objection(4.0, ["/left/arm"]) == "", "who has gone says nothing"
    activity.hear(5.0, status, {key: "active"})
    assert activity.objection(5.1, ["/left/arm"]) == ""
    activity.hear(6.0, status, {key: "unconfigured"})
    assert activity.objection(7.0, ["/left/arm"]) == "", "two robots of one name"
    activity.hear(8.0, status, {key: "unconfigured"})
    assert "is unconfigured" in activity.objection(8.1, ["/left/arm"])


def test_other_diagnostics_say_nothing_about_controllers() -> None:
    activity = Activity()
    activity.hear(1.0, "controller_manager: Hardware Components Activity", {"arm": "inactive"})
    assert activity.objection(1.0, ["/arm"]) == ""
