"""A robot's description (URDF) as a tree of bodies and joints."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from flex_ident.errors import UsageError
from flex_ident.recording import Floats
from flex_ident.robot.xml import parsed

KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


@dataclass(frozen=True)
class Body:
    """Mass, kg, its centre (3,), m, and the inertia (3, 3) about that, kg m^2, in the axes of its link."""

    mass: float
    centre: Floats
    inertia: Floats


NOTHING = Body(0.0, np.zeros(3), np.zeros((3, 3)))


@dataclass(frozen=True)
class DescribedJoint:
    """A joint with its place (3,), m, and `turn` (3, 3) in its parent's axes, and its unit `axis` (3,)."""

    name: str
    kind: str
    parent: str
    child: str
    place: Floats
    turn: Floats
    axis: Floats
    follows: tuple[str, float, float] | None = None
    """The joint that it mimics, times what, plus what."""

    def moved(self, position: float) -> tuple[Floats, Floats]:
        """Its place and turn in its parent's axes, at a position, rad or m."""
        if self.kind == "prismatic":
            return self.place + self.turn @ self.axis * position, self.turn
        if self.kind in ("revolute", "continuous"):
            turned: Floats = self.turn @ Rotation.from_rotvec(self.axis * position).as_matrix()
            return self.place, turned
        return self.place, self.turn


@dataclass(frozen=True)
class Robot:
    """Bodies by the name of their link, joints by their own."""

    bodies: dict[str, Body]
    joints: dict[str, DescribedJoint] = field(default_factory=dict)

    def behind(self, link: str) -> Iterator[DescribedJoint]:
        """The joints whose parent is that link."""
        return (joint for joint in self.joints.values() if joint.parent == link)

    def before(self, link: str) -> DescribedJoint | None:
        """The joint whose child is that link; None of the root."""
        return next((joint for joint in self.joints.values() if joint.child == link), None)


def read_robot(description: str) -> Robot:
    """The tree of a URDF. Raises UsageError with one line where it is none."""
    root = parsed(description, "the URDF")
    if root.tag != "robot":
        raise UsageError(f"the URDF's root is <{root.tag}>: expected <robot> (a xacro file must be expanded first).")
    bodies = {str(e.get("name")): _body(e) for e in root.findall("link")}
    joints = [_joint(e) for e in root.findall("joint") if e.get("type") is not None]
    names = [joint.name for joint in joints]
    if len(set(names)) < len(names):
        raise UsageError(f"the URDF has joint '{max(names, key=names.count)}' twice.")
    children = [joint.child for joint in joints]
    if len(set(children)) < len(children):
        raise UsageError(f"the URDF hangs link '{max(children, key=children.count)}' on two joints.")
    return Robot(bodies, dict(zip(names, joints, strict=True)))


def _body(element: ET.Element) -> Body:
    inertial = element.find("inertial")
    if inertial is None:
        return NOTHING
    where = f"link '{element.get('name')}'"
    place, turn = _origin(inertial, where)
    mass = _number(inertial.find("mass"), "value", 0.0, where)
    tensor = inertial.find("inertia")
    xx, yy, zz, xy, xz, yz = (_number(tensor, f"i{n}", 0.0, where) for n in ("xx", "yy", "zz", "xy", "xz", "yz"))
    own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if mass < 0.0:
        raise UsageError(f"the URDF gives {where} a mass of {mass:g} kg.")
    return Body(mass, place, turn @ own @ turn.T)


def _joint(element: ET.Element) -> DescribedJoint:
    name, kind = str(element.get("name")), str(element.get("type"))
    where = f"joint '{name}'"
    if kind not in KINDS:
        raise UsageError(f"the URDF's {where} is of type '{kind}': expected one of {', '.join(KINDS)}.")
    parent, child = (_named(element.find(tag), where, tag) for tag in ("parent", "child"))
    place, turn = _origin(element, where)
    along = element.find("axis")
    axis = _three("1 0 0" if along is None else along.get("xyz", "1 0 0"), where)
    length = float(np.linalg.norm(axis))
    if kind in ("revolute", "continuous", "prismatic") and not length > 0.0:
        raise UsageError(f"the URDF's {where} has no axis.")
    mimic = element.find("mimic")
    follows = None
    if mimic is not None:
        follows = (
            str(mimic.get("joint")),
            _number(mimic, "multiplier", 1.0, where),
            _number(mimic, "offset", 0.0, where),
        )
    return DescribedJoint(name, kind, parent, child, place, turn, axis / (length or 1.0), follows)


def _named(element: ET.Element | None, where: str, tag: str) -> str:
    name = None if element is None else element.get("link")
    if name is None:
        raise UsageError(f"the URDF's {where} has no <{tag} link=...>.")
    return name


def _origin(element: ET.Element, where: str) -> tuple[Floats, Floats]:
    """Place (3,) and turn (3, 3) of an element's origin: roll, pitch and yaw about fixed axes."""
    origin = element.find("origin")
    if origin is None:
        return np.zeros(3), np.eye(3)
    turn: Floats = Rotation.from_euler("xyz", _three(origin.get("rpy", "0 0 0"), where)).as_matrix()
    return _three(origin.get("xyz", "0 0 0"), where), turn


def _three(text: str, where: str) -> Floats:
    try:
        values = [float(part) for part in text.split()]
    except ValueError:
        values = []
    if len(values) != 3 or not all(map(math.isfinite, values)):
        raise UsageError(f"the URDF's {where} has '{text[:60]}' for three numbers.")
    return np.array(values)


def _number(element: ET.Element | None, name: str, default: float, where: str) -> float:
    text = None if element is None else element.get(name)
    if text is None:
        return default
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"the URDF's {where} has '{text[:60]}' for a number.")
    return value
