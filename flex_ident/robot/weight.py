"""Gravity on one joint by a robot's description.

With the unit axis a, the centre r of all that lies behind the joint as seen from it at position zero, and z upwards,
the torque that holds the weight m is the slope of its potential over the joint's position q: m g z . (a x r(q)). With
r(q) = cos q r + sin q a x r across the axis, that is g (MX cos q + MY sin q) with MX = m z . (a x r) and
MY = -m z . r, r across the axis.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flex_ident.errors import UsageError
from flex_ident.recording import Floats
from flex_ident.recording.weight import Weight
from flex_ident.robot.description import DescribedJoint, Robot, read_robot

UP = np.array([0.0, 0.0, 1.0])
"""Upwards in the axes of the description's root, as ROS has it (REP 103)."""
DEEPEST = 500
"""Joints in a row, at most."""


def weight_on(
    description: str, joint: str, positions: Mapping[str, float], *, moving: tuple[str, ...] = ()
) -> Weight:  # fmt: skip
    """What hangs on a joint of a URDF, the other joints at `positions`, rad or m, by name; what is missing counts as 0.

    `moving`: of the others, those that moved while it was recorded. Raises UsageError where the description has no such
    joint, or it does not turn.
    """
    robot = read_robot(description)
    own = robot.joints.get(joint)
    if own is None:
        known = ", ".join(name for name, j in robot.joints.items() if j.kind != "fixed")
        raise UsageError(f"the URDF has no joint '{joint}': it has {known or 'none that moves'}.")
    if own.kind not in ("revolute", "continuous"):
        raise UsageError(
            f"joint '{joint}' is {own.kind} in the URDF: gravity on a joint that does not turn is constant."
        )
    place = _Places(robot, positions)
    turn = np.eye(3)
    for before in _from_root(robot, own):
        turn = turn @ place.of(before)[1]
    axis, behind = own.axis, _gathered(robot, own, place)
    mass = sum(m for m, *_ in behind)
    centre = sum((m * c for m, c, _ in behind), np.zeros(3))
    across = centre - axis * float(axis @ centre)
    up = (turn @ own.turn).T @ UP  # upwards in the joint's own axes, at position zero
    inertia = sum(
        float(axis @ tensor @ axis) + m * float(np.sum((c - axis * float(axis @ c)) ** 2)) for m, c, tensor in behind
    )
    if not mass > 0.0:
        raise UsageError(f"the URDF gives nothing behind joint '{joint}' a mass.")
    used = place.asked
    return Weight(
        MX=float(up @ np.cross(axis, across)), MY=-float(up @ across), inertia=inertia,
        assumed=tuple(name for name in used if name not in positions),
        moving=tuple(name for name in used if name in moving),
    )  # fmt: skip


class _Places:
    """Where joints are, and which were asked for that can move."""

    def __init__(self, robot: Robot, positions: Mapping[str, float]) -> None:
        self._robot, self._positions = robot, positions
        self.asked: list[str] = []

    def of(self, joint: DescribedJoint) -> tuple[Floats, Floats]:
        """Place and turn of a joint in its parent's axes."""
        return joint.moved(self._position(joint, 0))

    def _position(self, joint: DescribedJoint, depth: int) -> float:
        if joint.kind not in ("revolute", "continuous", "prismatic"):
            return 0.0
        led = None if joint.follows is None else self._robot.joints.get(joint.follows[0])
        if joint.follows is not None and led is not None and joint.name not in self._positions and depth < DEEPEST:
            _, factor, offset = joint.follows
            return factor * self._position(led, depth + 1) + offset
        if joint.name not in self.asked:
            self.asked.append(joint.name)
        return float(self._positions.get(joint.name, 0.0))


def _from_root(robot: Robot, joint: DescribedJoint) -> list[DescribedJoint]:
    """The joints between root and joint, without it. Raises UsageError where they go round in a circle."""
    found: list[DescribedJoint] = []
    before = robot.before(joint.parent)
    while before is not None:
        found.append(before)
        if len(found) > DEEPEST:
            raise UsageError("the URDF's joints go round in a circle.")
        before = robot.before(before.parent)
    return found[::-1]


def _gathered(robot: Robot, joint: DescribedJoint, place: _Places) -> list[tuple[float, Floats, Floats]]:
    """Mass, centre (3,) and inertia (3, 3) about that of each body behind a joint, in its axes at position zero."""
    found: list[tuple[float, Floats, Floats]] = []
    waiting: list[tuple[str, Floats, Floats, int]] = [(joint.child, np.zeros(3), np.eye(3), 0)]
    while waiting:
        link, at, turn, depth = waiting.pop()
        if depth > DEEPEST:
            raise UsageError("the URDF's joints go round in a circle.")
        body = robot.bodies.get(link)
        if body is not None and body.mass > 0.0:
            found.append((body.mass, at + turn @ body.centre, turn @ body.inertia @ turn.T))
        for behind in robot.behind(link):
            there, turned = place.of(behind)
            waiting.append((behind.child, at + turn @ there, turn @ turned, depth + 1))
    return found
