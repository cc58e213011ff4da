"""Which message types hold joints by name, however a channel calls and encodes them."""

from __future__ import annotations

import re

from flex_ident.bags.messages import Topic

JOINT_STATE = "sensor_msgs/msg/JointState"
DYNAMIC_JOINT_STATE = "control_msgs/msg/DynamicJointState"
FOXGLOVE_JOINT_STATES = "foxglove_msgs/msg/JointStates"
JOINT_STATES_BY_NAME = (JOINT_STATE, DYNAMIC_JOINT_STATE, FOXGLOVE_JOINT_STATES)
KEYS = {JOINT_STATE: "name", DYNAMIC_JOINT_STATE: "joint_names interface_values", FOXGLOVE_JOINT_STATES: "joints"}
"""The fields of each type in which names stand."""
OTHER_NAMES = {"foxglove": "foxglove_msgs"}
"""Packages as they are called outside of ROS."""


def described_topic(name: str, serialisation: str, schema: str, schema_encoding: str, definition: bytes) -> Topic:
    """The topic of an MCAP channel, by the names and encodings of channel and schema."""
    encoding = {"json": "json", "protobuf": "protobuf", "ros1": "ros1"}.get(serialisation, "cdr")
    if encoding in ("json", "protobuf"):
        return Topic(
            name,
            _type_name(schema, name, encoding),
            "",
            encoding,
            encoding=encoding,
            schema=definition,
            schema_name=schema,
        )
    package, _, kind = schema.rpartition("/")
    full = schema if "/" in package else f"{package}/msg/{kind}"
    text = definition.decode("utf-8", "replace")
    return Topic(name, full, text, "idl" if schema_encoding.endswith("idl") else "msg", encoding=encoding)


def _type_name(schema: str, topic: str, encoding: str) -> str:
    """A schema's name as ROS writes it, where it is one of joint states: `foxglove.JointStates`, say.

    A JSON channel without schema counts as joint states by its topic's name.
    """
    parts = [part for part in re.split(r"[/.:]+", schema) if part and part != "msg"]
    full = "/msg/".join((OTHER_NAMES.get(parts[0], parts[0]), parts[-1])) if len(parts) > 1 else schema
    if full in JOINT_STATES_BY_NAME:
        return full
    if encoding == "json" and not parts and topic.endswith("joint_states"):
        return JOINT_STATE
    return next((known for known in JOINT_STATES_BY_NAME if parts == [known.rpartition("/")[2]]), schema)
