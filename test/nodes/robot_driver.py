"""The driver of the tests' robot: joint states, the robot's description, and the faults that both can have."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

import numpy as np
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import SetParametersResult
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.time import Time as RclpyTime
from robot_plant import Plant, Robot
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String

NOISE = 1e-5
LATE_S = 1.5
CLOCK_STEPS = {"time_jump": Duration(seconds=5.0), "time_back": Duration(seconds=-5.0)}
THIN_S = 0.1
"""Time between two messages of a topic that has thinned out."""
AWAY_S = 0.2
"""How long a driver is away that comes back with another quality of service."""
OFFSETS = {"jump": 0.3, "wrap": -math.tau, "nan": math.nan}
"""What is added to the positions that are read, rad."""


class Driver:
    """Publishes what is read of the joints, as the fault of the moment has it.

    Faults of the encoders on the links begin with `link_`. `leave` is called when the controller shall leave.
    """

    def __init__(self, robot: Robot, plant: Plant, leave: Callable[[], None]) -> None:
        self._robot, self._plant, self._leave = robot, plant, leave
        self.node = Node("robot", namespace=robot.namespace)
        self.node.declare_parameter("fault", "none")
        self.node.add_on_set_parameters_callback(self._on_parameters)
        self._states: Publisher | None = self._publisher(best_effort=robot.best_effort)
        self._links = self.node.create_publisher(JointState, "link_joint_states", 10) if robot.links else None
        self._clock = self.node.create_publisher(Clock, "/clock", 10) if robot.clock else None
        self._random = np.random.default_rng(0)
        self.fault = "none"
        self._frozen: np.ndarray | None = None
        self._since = self._began = time.monotonic()
        self._last: JointState | None = None
        self._last_link = JointState()
        self._thinned_at = 0.0
        self._waiting: deque[tuple[float, JointState]] = deque()
        if robot.description != "none":
            latched = robot.description == "latched"
            kept = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
            self._description = self.node.create_publisher(
                String, "robot_description", QoSProfile(depth=1, durability=kept)
            )
            self._description.publish(String(data=self._urdf()))

    def _publisher(self, *, best_effort: bool) -> Publisher:
        kept = ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE
        return self.node.create_publisher(JointState, "joint_states", QoSProfile(depth=10, reliability=kept))

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            self.fault, self._since = str(parameter.value), time.monotonic()
            self._robot.active = self.fault not in ("inactive", "halt")
            if self.fault == "halt":
                self._plant.halt()
            elif self.fault == "leave":
                self._leave()
            elif self.fault == "other_quality" and self._states is not None:
                self.node.destroy_publisher(self._states)
                self._states = None
        return SetParametersResult(successful=True)

    def _urdf(self) -> str:
        r = self._robot
        limit = f'<limit lower="{-r.limit}" upper="{r.limit}" velocity="{r.speed}" effort="{r.most_effort}"/>'
        joints = "".join(f'<joint name="{j}" type="{r.kind}">{limit}{r.extra}</joint>' for j in r.joints)
        return f'<robot name="r">{joints}{r.beside}</robot>'

    def _stamp(self) -> Time:
        """The time now, of the computer or of a simulator."""
        now = self.node.get_clock().now()
        if self._robot.pace is not None:
            now = RclpyTime(seconds=10.0 + self._robot.pace * (time.monotonic() - self._began))
        if self.fault in CLOCK_STEPS:
            now += CLOCK_STEPS[self.fault]
        return now.to_msg()

    def publish(self) -> None:
        """The joints as the robot says they are."""
        if self._clock is not None:
            self._clock.publish(Clock(clock=self._stamp()))
        if self._links is not None:
            self._publish_links(self._links)
        if self.fault == "other_quality" and self._states is None and time.monotonic() - self._since > AWAY_S:
            self._states = self._publisher(best_effort=True)
        if self._states is None or self.fault == "stop" or (self.fault == "thin" and self._thins()):
            return
        message = self._message()
        if self.fault == "repeat":
            message = self._last or message
        self._last = message
        self._waiting.append((time.monotonic(), message))
        late = min(LATE_S, 0.5 * (time.monotonic() - self._since)) if self.fault == "late" else self._robot.age_s
        while self._waiting and time.monotonic() - self._waiting[0][0] >= late:
            self._states.publish(self._waiting.popleft()[1])

    def _message(self) -> JointState:
        """A joint state, with what is wrong with its content."""
        r, p = self._robot, self._plant
        read = np.stack([p.position, p.velocity, p.effort])
        read += NOISE * self._random.standard_normal(read.shape)
        if r.wraps:
            read[0] = np.remainder(read[0] + math.pi, math.tau) - math.pi
        self._frozen = (read if self._frozen is None else self._frozen) if self.fault == "freeze" else None
        read = read if self._frozen is None else self._frozen
        offset = OFFSETS.get(self.fault, 0.0)
        read = read + (offset if math.isnan(offset) else np.array([[offset], [0.0], [0.0]]))
        names = r.joints if self.fault != "lose_joint" else r.joints[:1]
        message = JointState(name=names)
        message.header.stamp = self._stamp()
        message.position, message.velocity = (read[k, : len(names)].tolist() for k in (0, 1))
        if r.efforts:
            message.effort = read[2, : len(names)].tolist()
        return message

    def _publish_links(self, publisher: Publisher) -> None:
        """What the encoders on the links read."""
        if self.fault == "link_stop" or (self.fault == "link_thin" and self._thins()):
            return
        if self.fault != "link_freeze":
            read = self._plant.position + NOISE * self._random.standard_normal(len(self._robot.joints))
            self._last_link = JointState(name=self._robot.joints, position=read.tolist())
        self._last_link.header.stamp = self._stamp()
        publisher.publish(self._last_link)

    def _thins(self) -> bool:
        """Whether it is too early for the next message of a topic that has thinned out."""
        now = time.monotonic()
        early = now - self._thinned_at < THIN_S
        if not early:
            self._thinned_at = now
        return early
