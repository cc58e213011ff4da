"""The controller behind the command topic, asked for its own parameters and whether it is active."""

from __future__ import annotations

import time
from typing import Any

from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

from flex_ident.excitation.controllers import Controller
from flex_ident.nodes.controller_activity import ControllerActivity

FROM_DESIRED = ("interpolate_from_desired_state", "open_loop_control")
"""Either means the same; the latter is the older."""
KEYS = ("joints", "interface_name", "allow_partial_joints_goal", *FROM_DESIRED)
UNKNOWN = "_NODE_NAME_UNKNOWN"
ANSWER_S = 3.0
"""Time in which a node that takes the commands must answer; one that does not is no controller of ros2_control."""


class _Asked:
    """One node that takes commands, and its answer."""

    def __init__(self, node: Node, name: str) -> None:
        self.name = name
        self.since = time.monotonic()
        self.controller: Controller | None = None
        self.over = False
        self._node = node
        self._client = node.create_client(GetParameters, f"{name}/get_parameters")
        self._futures: dict[str, Any] = {}

    def look(self) -> None:
        """Ask once it can be asked, and take the answer once it is there."""
        if self.over:
            return
        if not self._futures and self._client.service_is_ready():
            # One by one: the answer about several is empty when a single one is not there.
            self._futures = {key: self._client.call_async(GetParameters.Request(names=[key])) for key in KEYS}
        if self._futures and all(future.done() for future in self._futures.values()):
            self._take({key: future.result() for key, future in self._futures.items()})
            self.end()
        elif time.monotonic() - self.since > ANSWER_S:
            self.end()

    def _take(self, answers: dict[str, Any]) -> None:
        given = {
            key: parameter_value_to_python(answer.values[0])
            for key, answer in answers.items()
            if answer is not None and answer.values
        }
        joints = given.get("joints")
        if isinstance(joints, list) and joints and all(isinstance(j, str) for j in joints):
            interface, partial = given.get("interface_name"), given.get("allow_partial_joints_goal")
            desired = [given[key] for key in FROM_DESIRED if isinstance(given.get(key), bool)]
            self.controller = Controller(
                self.name, tuple(joints), interface if isinstance(interface, str) and interface else None,
                partial if isinstance(partial, bool) else None, any(desired) if desired else None,
            )  # fmt: skip

    def end(self) -> None:
        """Ask no more."""
        if not self.over:
            self.over = True
            self._node.destroy_client(self._client)


class ControllerParameters:
    """Asks every node that takes the commands; `controllers` are those that say which joints they command."""

    def __init__(self, node: Node, topic: str) -> None:
        self._node, self._topic = node, topic
        self._activity = ControllerActivity(node)
        self._asked: dict[str, _Asked] = {}
        self._nameless: dict[str, float] = {}
        """When those were first seen whose names have yet to get around."""

    def look(self) -> None:
        """Ask who has come, take answers, forget who has gone."""
        there, nameless = {}, {}
        for info in self._node.get_subscriptions_info_by_topic(self._topic):
            mark = bytes(info.endpoint_gid).hex()
            if info.node_name.startswith(UNKNOWN):
                nameless[mark] = self._nameless.get(mark, time.monotonic())
            else:
                there[mark] = f"{info.node_namespace.rstrip('/')}/{info.node_name}"
        self._nameless = nameless
        for mark in list(self._asked):
            if mark not in there:
                self._asked.pop(mark).end()
        for mark, name in there.items():
            if mark not in self._asked:
                self._asked[mark] = _Asked(self._node, name)
        for asked in self._asked.values():
            asked.look()

    @property
    def controllers(self) -> list[Controller]:
        """Those that have answered."""
        return [a.controller for a in self._asked.values() if a.controller is not None]

    def problem(self, values: dict[str, Any]) -> str:
        """Why commands do not suit the controller, or that it has yet to answer or to be active; empty when they do."""
        for controller in self.controllers:
            given = values["command.type"], values["command.interface"], values["joint"], values["command.joints"]
            if why := controller.objection(*given):
                return why
        if self.completed(values) != values:
            return "command.joints is being filled in with the controller's: call again."
        waiting = [a.name for a in self._asked.values() if not a.over]
        waiting += ["a node" for since in self._nameless.values() if time.monotonic() - since < ANSWER_S]
        if waiting:
            return f"{', '.join(waiting)} has yet to say which joints it commands: call again."
        return self._activity.objection(a.name for a in self._asked.values())

    def advice(self, values: dict[str, Any]) -> str:
        """What about the controllers makes the joint follow worse than it could; empty when nothing does."""
        return " ".join(filter(None, (controller.advice(values["command.type"]) for controller in self.controllers)))

    def completed(self, values: dict[str, Any]) -> dict[str, Any]:
        """The parameters with `command.joints` filled in by a controller that says which they are."""
        for controller in self.controllers:
            joints = controller.completed(values["command.type"], values["joint"], values["command.joints"])
            if values["joint"] in joints:
                return {**values, "command.joints": joints}
        return values
