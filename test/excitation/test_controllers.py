"""What a controller's own parameters say against commands, without ROS."""

import pytest

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
