"""Settings as ROS parameters: described, range-checked, the same table as the command line's."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, ParameterType
from rclpy.node import Node

from flex_ident.configuration.files import parameters_in
from flex_ident.configuration.settings import Setting, Value
from flex_ident.errors import ConfigurationError
from flex_ident.nodes.parameter_files import parameter_files, refuse_files_that_do_not_apply

ANY_NODE = ("use_sim_time", "start_type_description_service")


def descriptor(setting: Setting, *, read_only: bool = False) -> ParameterDescriptor:
    """What `ros2 param describe` shows of a setting."""
    described = ParameterDescriptor(name=setting.key, description=setting.description, read_only=read_only)
    described.dynamic_typing = setting.many  # a list, or one text of all
    if setting.choices:
        described.additional_constraints = setting.range_text
    if isinstance(setting.default, float) and not isinstance(setting.default, bool):
        if math.isfinite(setting.lower) and math.isfinite(setting.upper):
            described.floating_point_range = [FloatingPointRange(from_value=setting.lower, to_value=setting.upper)]
        described.type = ParameterType.PARAMETER_DOUBLE
        described.dynamic_typing = True  # a whole number in a YAML file is still a number
    return described


def declare(node: Node, settings: Iterable[Setting], *, read_only: bool = False) -> None:
    """Declare every setting. Raises ConfigurationError that names the file, the key and what is allowed."""
    for setting in settings:
        given = node._parameter_overrides.get(setting.key)
        if given is not None:
            setting.checked(given.value, origin(node, setting.key))
        node.declare_parameter(setting.key, setting.default, descriptor(setting, read_only=read_only))


def current(node: Node, settings: Iterable[Setting]) -> dict[str, Value]:
    """The settings' values now, checked. Raises ConfigurationError."""
    return {s.key: s.checked(node.get_parameter(s.key).value, node.get_name()) for s in settings}


def refuse_unknown(node: Node, others: Iterable[str] = ()) -> None:
    """Refuse what was given and not declared, after all is declared, and files that hold nothing for this node.

    Raises ConfigurationError that names it.

    `others` are keys that commands know and a file for both may hold.
    """
    refuse_files_that_do_not_apply(node)
    known = {*node.list_parameters([], 0).names, *ANY_NODE, *others}
    for key in node._parameter_overrides:
        if key not in known and not key.startswith("qos_overrides."):
            close = difflib.get_close_matches(key, known, 1)
            hint = f"did you mean '{close[0]}'?" if close else "see 'ros2 param list'."
            raise ConfigurationError(f"{origin(node, key)}: unknown parameter '{key}': {hint}")


def origin(node: Node, key: str) -> str:
    """Where a parameter was given: the parameter file that holds it, else the node's name."""
    for file in reversed(parameter_files()):
        try:
            if key in parameters_in(file, (node.get_name(),)):
                return str(file)
        except ConfigurationError:
            continue
    return str(node.get_name())
