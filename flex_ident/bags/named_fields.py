"""Fields of joints by name in any message: beside a list of names, or in a list of messages that each have a name.

`joint_2.reference.positions` of a JointTrajectoryControllerState, `measured_joint_state.fr3_joint4.effort` of a
FrankaRobotState.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rosbags.interfaces import Nodetype

from flex_ident.bags.definitions import Definitions
from flex_ident.bags.message_numbers import Layout, Numbers

LISTS = ("joint_names", "names", "name")
"""Fields that list names, one for each number of the arrays beside them."""


@dataclass(frozen=True)
class Named:
    """A joint's field `rest`, NAME.FIELD, in the message at `path`; `names` lists the names, or is empty for a list of
    messages that have a `name` each.
    """

    path: str
    names: str
    rest: str

    @property
    def key(self) -> str:
        """The outermost field in which the names stand."""
        return (self.path or self.names).partition(".")[0]

    def holds(self, layout: Layout) -> bool:
        """Whether messages of this layout name the joint."""
        return self._joint(layout) is not None

    def number(self, layout: Layout) -> Numbers | None:
        """The joint's number; None where its array is empty or too short, or there is no such field."""
        joint = self._joint(layout)
        if joint is None:
            return None
        index, field = joint
        if not self.names:
            found = layout.numbers.get(f"{self.path}.{index}.{field}")
            return found.element(0) if found is not None and found.count == 1 else None
        found = layout.numbers.get(_joined(self.path, field))
        return found.element(index) if found is not None and index < found.count else None

    def _joint(self, layout: Layout) -> tuple[int, str] | None:
        """The joint's number in the list, and its field: of the longest name that `rest` begins with."""
        pattern = f"{_joined(self.path, self.names)}.{{}}" if self.names else f"{self.path}.{{}}.name"
        best: tuple[int, str] | None = None
        i = 0
        while (name := layout.texts.get(pattern.format(i))) is not None:
            if self.rest.startswith(f"{name}.") and (best is None or len(self.rest) - len(name) - 1 < len(best[1])):
                best = (i, self.rest[len(name) + 1 :])
            i += 1
        return best


def _joined(*parts: str) -> str:
    return ".".join(part for part in parts if part)


def named_field(definitions: Definitions, message_type: str, path: str) -> Named | None:
    """The joint's field that `path` may mean, where it leads to no field; None where no names stand on its way."""
    kind: Any = (Nodetype.NAME, message_type)
    parts = path.split(".")
    for done, part in enumerate(parts):
        before, rest = ".".join(parts[:done]), ".".join(parts[done:])
        if kind[0] == Nodetype.NAME:
            fields = dict(definitions[kind[1]][1])
            if part in fields:
                kind = fields[part]
                continue
            names = next((name for name in LISTS if name in fields and _is_text_list(fields[name])), None)
            return Named(before, names, rest) if names and "." in rest else None
        if kind[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE) and kind[1][0][0] == Nodetype.NAME and not part.isdigit():
            fields = dict(definitions[kind[1][0][1]][1])
            own = fields.get("name")
            is_text = own is not None and own[0] == Nodetype.BASE and own[1][0] == "string"
            return Named(before, "", rest) if is_text and "." in rest else None
        if kind[0] not in (Nodetype.ARRAY, Nodetype.SEQUENCE) or not part.isdigit():
            return None
        kind = kind[1][0]
    return None


def _is_text_list(kind: Any) -> bool:
    if kind[0] not in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return False
    (element, detail), _ = kind[1]
    return bool(element == Nodetype.BASE and detail[0] == "string")
