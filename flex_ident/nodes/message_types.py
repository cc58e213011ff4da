"""Message types by name: their Python class, full definition and hash, whether rosbags knows them or not."""

from __future__ import annotations

import importlib
import os
import sys
from functools import cache
from pathlib import Path
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore
from std_msgs.msg import Header

from flex_ident.errors import UsageError


def message_class(message_type: str) -> Any:
    """The Python class of `pkg/msg/Name`. Raises UsageError when it is not installed."""
    parts = message_type.split("/")
    try:
        package, kind, name = parts
        return getattr(importlib.import_module(f"{package}.{kind}"), name)
    except (ValueError, ImportError, AttributeError) as error:
        raise UsageError(f"the type {message_type} is not installed here.") from error


def without_stamp(message_type: str, data: bytes) -> object:
    """A message, to be compared with others of its topic, whenever they were sent; its bytes where they are none."""
    try:
        message = deserialize_message(data, message_class(message_type))
        if isinstance(getattr(message, "header", None), Header):
            message.header.stamp = Time()
    except Exception:  # whatever rclpy makes of bytes that are no message
        return data
    return message


@cache
def definition_and_digest(message_type: str) -> tuple[str, str]:
    """Full definition and RIHS01 hash of a type. Raises UsageError when its definition is not installed."""
    store = _store()
    _register(store, message_type)
    definition, _ = store.generate_msgdef(message_type, ros_version=2)
    return definition, store.hash_rihs01(message_type)


@cache
def _store() -> Typestore:
    return get_typestore(Stores.ROS2_JAZZY)


def _register(store: Typestore, message_type: str) -> None:
    """Take a type's definition, and those that it is made of, from the installation."""
    if message_type in store.types:
        return
    found = get_types_from_msg(_installed_definition(message_type), message_type)
    for fields in found.values():
        for inner in _inner_types(fields[1]):
            if inner not in found:
                _register(store, inner)
    store.register(found)


def _inner_types(fields: Any) -> set[str]:
    """Names of the message types among a definition's fields, those in arrays and sequences too."""
    names: set[str] = set()
    for _, (_, detail) in fields:
        inner = detail[0][1] if isinstance(detail[0], tuple) else detail
        if isinstance(inner, str):
            names.add(inner)
    return names


def _installed_definition(message_type: str) -> str:
    package, kind, name = message_type.split("/")
    prefixes = [p for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    for prefix in (*prefixes, sys.prefix):
        path = Path(prefix) / "share" / package / kind / f"{name}.msg"
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise UsageError(f"the definition of {message_type} is not installed here: source the workspace that has it.")
