"""A robot written by somebody else: drives, joint states, and stand-ins for ros2_control's two controllers.

What was measured on ros2_control 4.46 is so here: a command stands until the next one comes, there is no timeout;
commands are taken best effort; a forward command goes to the joints in the controller's order, whatever the sender
meant, and its size alone is checked; a trajectory that does not name all joints is rejected unless the controller
allows that; an inactive controller keeps its subscription and ignores what comes. Run as a process:
`python robot.py '{"key": value}'`, keys as in `Robot`. What the joints really do goes to the file `truth`, a line each
millisecond or so: time, s, of the steady clock, then position, speed and effort of each joint.
"""

from __future__ import annotations

import gc
import json
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from robot_driver import Driver
from robot_plant import Plant, Robot, driven, in_real_time
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory


class Controller:
    """One of ros2_control's controllers as the network sees it."""

    def __init__(self, robot: Robot, plant: Plant) -> None:
        self._robot, self._plant = robot, plant
        self.node = Node(robot.controller, namespace=robot.namespace)
        self.node.declare_parameter("joints", robot.controlled)
        if robot.trajectory:
            self.node.declare_parameter("command_interfaces", [robot.interface])
            self.node.declare_parameter("allow_partial_joints_goal", robot.partial)
            self.node.declare_parameter("interpolate_from_desired_state", robot.from_desired)
            self._subscription = self._subscribed(JointTrajectory, "~/joint_trajectory", self._trajectory)
        else:
            self.node.declare_parameter("interface_name", robot.interface)
            self._subscription = self._subscribed(Float64MultiArray, "~/commands", self._forward)
        if robot.manager:
            self._diagnostics = self.node.create_publisher(DiagnosticArray, "/diagnostics", 10)
            self.node.create_timer(1.0, self._say)

    def _subscribed(self, kind: type, topic: str, take: Callable[[Any], None]) -> Subscription:
        quality = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
        return self.node.create_subscription(kind, topic, take, quality)

    def leave(self) -> None:
        """Take no more commands; the last one stands."""
        self.node.destroy_subscription(self._subscription)

    def _say(self) -> None:
        """What ros2_control's controller manager tells the diagnostics, among what others do."""
        states = {"joint_state_broadcaster": "active", self._robot.controller: "active"}
        if not self._robot.active:
            states[self._robot.controller] = "inactive"
        values = [KeyValue(key=key, value=value) for key, value in states.items()]
        activity = DiagnosticStatus(
            name="controller_manager: Controllers Activity", hardware_id="ros2_control", values=values
        )
        components = [KeyValue(key=self._robot.controller, value="inactive")]
        hardware = DiagnosticStatus(name="controller_manager: Hardware Components Activity", values=components)
        self._diagnostics.publish(DiagnosticArray(status=[activity, hardware]))

    def _forward(self, message: Float64MultiArray) -> None:
        if self._robot.active and len(message.data) == len(self._robot.controlled):
            for joint, value in zip(self._robot.controlled, message.data, strict=True):
                self._plant.command(joint, value)

    def _trajectory(self, message: JointTrajectory) -> None:
        missing = set(self._robot.controlled) - set(message.joint_names)
        unknown = set(message.joint_names) - set(self._robot.controlled)
        if not self._robot.active or unknown or (missing and not self._robot.partial):
            return
        for joint, value in zip(message.joint_names, message.points[-1].positions, strict=True):
            self._plant.command(joint, value)


def main() -> None:
    """Run the robot until the process is ended."""
    robot = Robot(**json.loads(sys.argv[1]))
    plant = Plant(robot)
    drives = driven(plant, robot)  # before there are threads
    try:
        serve(robot, plant)
    finally:
        os.kill(drives, signal.SIGKILL)


def serve(robot: Robot, plant: Plant) -> None:
    """Take commands and publish joint states."""
    in_real_time()
    rclpy.init()
    controller = Controller(robot, plant)
    driver = Driver(robot, plant, controller.leave)
    executor = SingleThreadedExecutor()
    executor.add_node(driver.node)
    executor.add_node(controller.node)
    gc.collect()
    gc.freeze()  # a collection would hold both up for a third of a second
    period = 1.0 / robot.rate_hz
    published = time.monotonic()
    while rclpy.ok():
        executor.spin_once(timeout_sec=0.5 * period)
        now = time.monotonic()
        if now - published >= period:
            published = max(published + period, now - 5.0 * period)
            driver.publish()


if __name__ == "__main__":
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        main()
    rclpy.try_shutdown()
