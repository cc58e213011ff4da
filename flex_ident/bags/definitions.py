"""What the fields of a message type are: by the user's file, ROS, the bag, or what is known of robots' drivers."""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from flex_ident.bags.known_types import KNOWN_TYPES
from flex_ident.bags.messages import Topic
from flex_ident.errors import SignalError

Definitions = Mapping[str, Any]
"""Fields of each message type, as rosbags describes them."""
EMPTY = "structure_needs_at_least_one_member"
"""The byte that stands for a message without fields; ROS 1 does without."""


def versions_of(topic: Topic, *, ros1: bool) -> tuple[tuple[Definitions, ...], bool]:
    """Fields of the topic's message type and of all types in it, and whether that is certain.

    Where neither ROS nor the bag defines the type, there may be several versions of which one has to fit. Raises
    SignalError when the type is not known.
    """
    standard = _standard(ros1)
    if topic.given:
        return (_complete(topic, standard, first=True),), False
    if topic.message_type in standard or topic.definition:
        try:
            return (_complete(topic, standard),), True
        except SignalError:
            if topic.message_type not in KNOWN_TYPES:
                raise
    versions = KNOWN_TYPES.get(topic.message_type)
    if versions is None:
        raise _unknown(topic)
    return tuple(
        _complete(replace(topic, definition=text, definition_format="msg"), standard) for text in versions
    ), False


@functools.cache
def _standard(ros1: bool) -> dict[str, Any]:
    """Fields of the types that ROS itself defines; not to be changed."""
    store: Any = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
    return dict(store.fielddefs)


def _complete(topic: Topic, standard: dict[str, Any], *, first: bool = False) -> Definitions:
    """The standard definitions and the topic's own; `first`: its own before the standard ones."""
    definitions = standard
    try:
        if first or topic.message_type not in standard:
            given: Any = {}
            if topic.definition_format == "idl":
                for part in re.split(r"^={80}\nIDL: .*\n", topic.definition, flags=re.MULTILINE):
                    given |= get_types_from_idl(part) if part.strip() else {}
            else:
                given = get_types_from_msg(topic.definition, topic.message_type)
            definitions = {**standard, **given} if first else {**given, **standard}
        _check_known(definitions, topic.message_type)
    except Exception as error:
        missing = f" ({error.args[0]} is not among its types)" if isinstance(error, KeyError) and error.args else ""
        if topic.given:
            raise SignalError(f"--type-file does not define {topic.message_type}{missing}.") from error
        raise _unknown(topic) from error
    return definitions


def _unknown(topic: Topic) -> SignalError:
    return SignalError(
        f"{topic.name} is of type {topic.message_type}, which neither ROS nor the bag defines: name another topic, or "
        "its definition with --type-file X.msg."
    )


def _check_known(
    definitions: Definitions, message_type: str, done: set[str] | None = None, outer: tuple[str, ...] = ()
) -> None:
    """Raise KeyError when a type within `message_type` has no definition, and RecursionError when one holds itself.

    Types that are `done` are not looked into again: one of ten fields of the next, and so on, would never end.
    """
    done = set() if done is None else done
    if message_type in outer:
        raise RecursionError(message_type)
    for _, (kind, detail) in definitions[message_type][1]:
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            kind, detail = detail[0]
        if kind == Nodetype.NAME and detail not in done:
            _check_known(definitions, detail, done, (*outer, message_type))
    done.add(message_type)
