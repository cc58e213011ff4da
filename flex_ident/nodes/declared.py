"""Settings as ROS parameters: described, range-checked, the same table as the command line's."""

from __future__ import annotations

import math
from collections.abc import Iterable

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, ParameterType
from rclpy.node import Node

from flex_ident.configuration.settings import Setting, Value


def descriptor(setting: Setting, *, read_only: bool = False) -> ParameterDescriptor:
    """What `ros2 param describe` shows of a setting."""
    described = ParameterDescriptor(name=setting.key, description=setting.description, read_only=read_only)
    if setting.choices:
        described.additional_constraints = setting.range_text
    if isinstance(setting.default, float) and not isinstance(setting.default, bool):
        if math.isfinite(setting.lower) and math.isfinite(setting.upper):
            described.floating_point_range = [FloatingPointRange(from_value=setting.lower, to_value=setting.upper)]
        described.type = ParameterType.PARAMETER_DOUBLE
        described.dynamic_typing = True  # a whole number in a YAML file is still a number
    return described


def declare(node: Node, settings: Iterable[Setting], *, read_only: bool = False) -> None:
    """Declare every setting; a value that does not fit raises rclpy's InvalidParameterValueException."""
    for setting in settings:
        node.declare_parameter(setting.key, setting.default, descriptor(setting, read_only=read_only))


def current(node: Node, settings: Iterable[Setting]) -> dict[str, Value]:
    """The settings' values now, checked. Raises ConfigurationError."""
    return {s.key: s.checked(node.get_parameter(s.key).value, node.get_name()) for s in settings}
