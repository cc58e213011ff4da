"""From a place, as the user names it, to its number in a message."""

from __future__ import annotations

from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from flex_ident.bags.layouts import Layout, MessageLayouts, Numbers, joint_numbers
from flex_ident.bags.messages import Topic
from flex_ident.bags.motions import is_joint_state
from flex_ident.bags.selection import Place
from flex_ident.errors import SignalError


class PlaceReader:
    """Finds one place in the layouts of its topic. Raises SignalError when the message type has no such field."""

    def __init__(self, place: Place, topic: Topic, layouts: MessageLayouts) -> None:
        self._place, self._topic = place, topic
        self._path = "" if is_joint_state(topic) else self._checked_path(layouts.definitions)

    def holds(self, layout: Layout) -> bool:
        """Whether messages of this layout speak of the place at all: a joint may be missing from some."""
        return bool(self._path) or self._place.name in layout.names

    def number(self, layout: Layout) -> Numbers | None:
        """The single number; None where the driver left its array empty or too short."""
        if not self._path:
            names = layout.names
            joints = joint_numbers(layout, self._place.field, len(names))
            return None if joints is None else _element(joints, names.index(self._place.name))
        found = layout.numbers.get(self._path)
        if found is not None:
            if found.count > 1:
                raise SignalError(
                    f"{self._place.source} is {found.count} numbers: say which, as in "
                    f"{self._topic.name}:{self._path}.0."
                )
            return found if found.count else None
        array, _, index = self._path.rpartition(".")
        found = layout.numbers.get(array)
        return _element(found, int(index)) if found is not None and int(index) < found.count else None

    def _checked_path(self, definitions: Any) -> str:
        """The place's path, `data` where none is given, led through the definition of the message type."""
        kind: Any = (Nodetype.NAME, self._topic.message_type)
        fields = dict(definitions[self._topic.message_type][1])
        names = self._place.field.split(".") if self._place.field else ["data"] if "data" in fields else []
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
            within = ", ".join(name for name, _ in definitions[kind[1]][1])
            raise SignalError(f"{self._place.source} is not a number but a message: add a field of it, of {within}.")
        if (kind if kind[0] == Nodetype.BASE else kind[1][0])[1][0] == "string":
            raise SignalError(f"{self._place.source} is a text, not a number: name another field.")
        return ".".join(names)

    def _missing(self, name: str, fields: dict[str, Any]) -> SignalError:
        return SignalError(
            f"{self._topic.name} ({self._topic.message_type}) has no field '{name}': it has "
            f"{', '.join(fields) or 'none there'}."
        )


def _element(numbers: Numbers, index: int) -> Numbers:
    size = np.dtype(numbers.dtype).itemsize
    return Numbers(numbers.offset + size * index, numbers.dtype, 1)
