"""What a joint may do: the tighter of the parameters and the robot's URDF."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass

from flex_ident.errors import ConfigurationError, UsageError
from flex_ident.robot.xml import parsed


@dataclass(frozen=True)
class Limits:
    """Bounds of one joint: position, rad, speed, rad/s, effort, N m, and tracking error, rad; infinite: none.

    Raises ConfigurationError.
    """

    position_min: float = -math.inf
    position_max: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf
    tracking_error: float = math.inf

    def __post_init__(self) -> None:
        if not self.position_min < self.position_max:
            raise ConfigurationError(
                f"limits.position_min {self.position_min} is not below limits.position_max {self.position_max}."
            )
        for name in ("velocity", "effort", "tracking_error"):
            if not getattr(self, name) > 0.0:
                raise ConfigurationError(f"limits.{name} is {getattr(self, name)}: it must be positive.")

    def tightened(self, other: Limits) -> Limits:
        """The tighter of both, bound by bound. Raises ConfigurationError when nothing is left."""
        return Limits(
            max(self.position_min, other.position_min), min(self.position_max, other.position_max),
            min(self.velocity, other.velocity), min(self.effort, other.effort),
            min(self.tracking_error, other.tracking_error),
        )  # fmt: skip

    def held(self, position: float) -> float:
        """The nearest position inside the bounds."""
        return min(max(position, self.position_min), self.position_max)


def urdf_limits(description: str, joint: str) -> Limits:
    """The limits that a URDF gives a joint, its soft limits included.

    Raises UsageError when it is no XML, has no such joint, or the joint cannot move.
    """
    root = _parsed(description)
    # A joint of the kinematics has a type; those below <ros2_control> and <transmission> have none.
    found = [e for e in root.iter("joint") if e.get("name") == joint and e.get("type") is not None]
    if not found:
        raise UsageError(f"robot_description has no joint '{joint}'.")
    kind = found[0].get("type")
    if kind == "fixed":
        raise UsageError(f"joint '{joint}' is fixed in robot_description: it cannot move.")
    mimic = found[0].find("mimic")
    if mimic is not None:
        raise UsageError(
            f"joint '{joint}' mimics {mimic.get('joint')!r} in robot_description and has no drive of its own: name "
            "the latter."
        )
    if _passive(root, joint):
        raise UsageError(f"joint '{joint}' has no command interface in robot_description: it is passive.")
    hard, soft = _attributes(found[0], "limit"), _attributes(found[0], "safety_controller")
    low = max(hard.get("lower", -math.inf), soft.get("soft_lower_limit", -math.inf))
    high = min(hard.get("upper", math.inf), soft.get("soft_upper_limit", math.inf))
    bounded = kind != "continuous" and low < high
    return Limits(
        low if bounded else -math.inf, high if bounded else math.inf,
        _positive(hard.get("velocity", math.nan)), _positive(hard.get("effort", math.nan)),
    )  # fmt: skip


def is_continuous(description: str, joint: str) -> bool:
    """Whether a URDF says that a joint turns without end. Raises UsageError when it is no XML."""
    root = _parsed(description)
    return any(e.get("name") == joint and e.get("type") == "continuous" for e in root.iter("joint"))


def _parsed(description: str) -> ET.Element:
    return parsed(description, "robot_description")


def _passive(root: ET.Element, joint: str) -> bool:
    """Whether ros2_control reads a joint and does not command it."""
    found = [e for control in root.iter("ros2_control") for e in control.iter("joint") if e.get("name") == joint]
    read = [e for e in found if e.find("state_interface") is not None]
    return bool(read) and all(e.find("command_interface") is None for e in found)


def _attributes(element: ET.Element, tag: str) -> dict[str, float]:
    """The numbers among the attributes of a child element."""
    child = element.find(tag)
    numbers: dict[str, float] = {}
    for name, text in ({} if child is None else child.attrib).items():
        try:
            value = float(text)
        except ValueError:
            continue
        if math.isfinite(value):
            numbers[name] = value
    return numbers


def _positive(value: float) -> float:
    return value if math.isfinite(value) and value > 0.0 else math.inf


def gravity_rest(mx: float, my: float, near: float) -> float:
    """The position, rad, nearest to `near` at which gravity pulls nothing (eq. 17): MX cos q + MY sin q = 0.

    Raises ConfigurationError when neither first moment is given.
    """
    if mx == 0.0 and my == 0.0:
        raise ConfigurationError("start_position is gravity_rest: give mx and my, kg m.")
    base = math.atan2(-mx, my)
    turns = round((near - base) / math.pi)
    return base + turns * math.pi
