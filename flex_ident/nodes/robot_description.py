"""The robot's description as it comes: kept by its publisher for those who come later, or not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

from flex_ident.errors import FlexIdentError
from flex_ident.excitation import Exciter
from flex_ident.excitation.limits import is_continuous, urdf_limits
from flex_ident.excitation.surroundings import Description
from flex_ident.nodes.exciter_settings import Experiment
from flex_ident.nodes.exciter_state import LATCHED


class RobotDescription:
    """`text` is the latest, None while there is none; `changed` is called when another comes."""

    def __init__(self, node: Node, changed: Callable[[], None]) -> None:
        self.text: str | None = None
        self.topic = str(node.resolve_topic_name("robot_description"))
        self._node, self._changed = node, changed
        self._volatile = False
        node.create_subscription(String, self.topic, self._on_message, LATCHED)

    def _on_message(self, message: String) -> None:
        if message.data != self.text:
            self.text = message.data
            self._changed()

    def state(self) -> Description:
        """What is known of it; one that is not kept for those who come later is listened to from now on."""
        if self.text is not None:
            return "here"
        offers = self._node.get_publishers_info_by_topic(self.topic)
        if not offers:
            return "absent"
        if any(o.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for o in offers):
            return "announced"
        if not self._volatile:
            self._volatile = True
            self._node.create_subscription(String, self.topic, self._on_message, QoSProfile(depth=1))
        return "volatile"


def exciter_within(found: Experiment, description: str | None) -> tuple[Exciter, str]:
    """The rules of an experiment, its limits tightened by a URDF, and what is wrong with that, else empty."""
    limits, settings, problem = found.limits, found.exciter, ""
    if description is not None:
        try:
            limits = limits.tightened(urdf_limits(description, settings.joint))
            held = tuple(urdf_limits(description, joint).effort for joint in settings.held)
            continuous = tuple(is_continuous(description, joint) for joint in (settings.joint, *settings.held))
            settings = replace(settings, held_effort=held, continuous=continuous)
        except FlexIdentError as error:
            problem = str(error)
    return Exciter(settings, found.reference, limits), problem
