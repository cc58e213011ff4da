"""From a place, as the user names it, to its number in a message."""

from __future__ import annotations

from typing import Any

from rosbags.interfaces import Nodetype

from flex_ident.bags.decoding import Layouts
from flex_ident.bags.definitions import Definitions
from flex_ident.bags.layouts import joint_numbers
from flex_ident.bags.message_numbers import Layout, Numbers, Scattered
from flex_ident.bags.messages import Topic
from flex_ident.bags.motions import is_joint_state
from flex_ident.bags.named_fields import Named, named_field
from flex_ident.bags.selection import Place, dotted
from flex_ident.errors import SignalError
from flex_ident.recording.names import first_of

MOST_LISTED = 24
"""Fields that a message lists."""


class PlaceReader:
    """Finds one place in the layouts of its topic. Raises SignalError when the message type has no such field."""

    def __init__(self, place: Place, topic: Topic, layouts: Layouts) -> None:
        self._place, self._topic = place, topic
        self._joint = is_joint_state(topic) and bool(place.name)
        self._named: Named | None = None
        self._path = dotted(place.field)
        self._found = False
        self._last: Layout | None = None
        if not self._joint and layouts.versions:
            self._path = self._checked_path(layouts)

    def holds(self, layout: Layout) -> bool:
        """Whether messages of this layout speak of the place at all: a joint may be missing from some."""
        self._last = layout
        if self._joint:
            return self._place.name in layout.names
        return self._named is None or self._named.holds(layout)

    def number(self, layout: Layout) -> Numbers | None:
        """The single number; None where the driver left its array empty or too short."""
        if self._joint:
            names = layout.names
            joints = joint_numbers(layout, self._place.field, len(names))
            return None if joints is None else joints.element(names.index(self._place.name))
        if self._named is not None:
            return self._named.number(layout)
        found = layout.numbers.get(self._path)
        if found is not None:
            self._found = True
            if found.count > 1:
                raise SignalError(
                    f"{self._place.source} is {found.count} numbers: say which, as in "
                    f"{self._topic.name}:{self._path}.0."
                )
            return found.element(0) if found.count else None
        array, _, index = self._path.rpartition(".")
        found = layout.numbers.get(array) if index.isdigit() else None
        self._found |= found is not None
        return found.element(int(index)) if found is not None and int(index) < found.count else None

    def refuse_absent(self, layouts: Layouts) -> None:
        """Raise SignalError for a field that no message has, where only messages tell which there are."""
        if self._joint or self._named is not None or layouts.versions or self._found or self._last is None:
            return
        there = [path for path, own in self._last.numbers.items() if not isinstance(own, Scattered)]
        raise SignalError(
            f"{self._topic.name} has no field '{self._path}': it has {first_of(there, MOST_LISTED) or 'no number'}."
        )

    def _checked_path(self, layouts: Layouts) -> str:
        """The place's path, `data` where none is given, led through one of the definitions of the message type."""
        complaints = []
        for definitions in layouts.versions:
            try:
                return self._path_in(definitions)
            except SignalError as error:
                self._named = named_field(definitions, self._topic.message_type, self._path)
                if self._named is not None:
                    layouts.tell_apart(self._named.key)
                    return self._path
                complaints.append(error)
        raise complaints[0]

    def _path_in(self, definitions: Definitions) -> str:
        kind: Any = (Nodetype.NAME, self._topic.message_type)
        fields = dict(definitions[self._topic.message_type][1])
        names = self._path.split(".") if self._path else ["data"] if "data" in fields else []
        for name in names:
            if kind[0] == Nodetype.NAME:
                fields = dict(definitions[kind[1]][1])
                if name not in fields:
                    raise self._missing(name, fields)
                kind = fields[name]
            elif kind[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE) and name.isdigit():
                kind = kind[1][0]
            else:
                raise self._missing(name, {})
        if kind[0] == Nodetype.NAME:
            within = first_of([name for name, _ in definitions[kind[1]][1]], MOST_LISTED)
            raise SignalError(f"{self._place.source} is not a number but a message: add a field of it, of {within}.")
        if (kind if kind[0] == Nodetype.BASE else kind[1][0])[1][0] == "string":
            raise SignalError(f"{self._place.source} is a text, not a number: name another field.")
        return ".".join(names)

    def _missing(self, name: str, fields: dict[str, Any]) -> SignalError:
        return SignalError(
            f"{self._topic.name} ({self._topic.message_type}) has no field '{name}': it has "
            f"{first_of(fields, MOST_LISTED) or 'none there'}."
        )
