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
import math
import os
import sys
import threading
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory

INERTIA, DAMPING, GRAVITY = 1.0, 8.0, 2.0
"""Of each joint under effort commands: kg m^2, N m s/rad, N m that a joint at rest must be held with."""
POSITION_S, VELOCITY_S = 0.01, 0.005
"""Time constants of the position and the velocity drives."""
PRIORITY = 30
NOISE = 1e-5
LATE_S = 1.5
CLOCK_STEP = Duration(seconds=5.0)
STEP_S, LONGEST_STEP_S = 1e-3, 0.05


@dataclass
class Robot:
    """How the robot is; `joints` in the order of the joint states, `controlled` in the controller's."""

    joints: list[str] = field(default_factory=lambda: ["shoulder", "elbow"])
    controlled: list[str] = field(default_factory=lambda: ["shoulder", "elbow"])
    positions: list[float] = field(default_factory=lambda: [0.5, 0.0])
    interface: str = "position"
    controller: str = "forward_position_controller"
    trajectory: bool = False
    partial: bool = False
    active: bool = True
    manager: bool = False
    """Whether a controller manager says once a second which controllers are active."""
    from_desired: bool = False
    rate_hz: float = 500.0
    limit: float = 0.4
    speed: float = 2.0
    most_effort: float = 60.0
    kind: str = "revolute"
    wraps: bool = False
    efforts: bool = True
    description: str = "latched"
    best_effort: bool = False
    """Whether the joint states are."""
    extra: str = ""
    """Further XML in the joint that moves."""
    namespace: str = ""
    truth: str = ""


class Controller:
    """One of ros2_control's controllers as the network sees it."""

    def __init__(self, robot: Robot, plant: Plant) -> None:
        self._robot, self._plant = robot, plant
        self.node = Node(robot.controller, namespace=robot.namespace)
        self.node.declare_parameter("joints", robot.controlled)
        best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
        if robot.trajectory:
            self.node.declare_parameter("command_interfaces", [robot.interface])
            self.node.declare_parameter("allow_partial_joints_goal", robot.partial)
            self.node.declare_parameter("interpolate_from_desired_state", robot.from_desired)
            self.node.create_subscription(JointTrajectory, "~/joint_trajectory", self._trajectory, best_effort)
        else:
            self.node.declare_parameter("interface_name", robot.interface)
            self.node.create_subscription(Float64MultiArray, "~/commands", self._forward, best_effort)
        if robot.manager:
            self._diagnostics = self.node.create_publisher(DiagnosticArray, "/diagnostics", 10)
            self.node.create_timer(1.0, self._say)

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


class Plant:
    """The joints and their drives."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        n = len(robot.joints)
        self.position = np.array(robot.positions, float)
        self.velocity = np.zeros(n)
        self.effort = np.full(n, GRAVITY)
        self._halted: np.ndarray | None = None
        self._commands = {
            "position": self.position.copy(), "velocity": np.zeros(n), "effort": np.full(n, GRAVITY)
        }[robot.interface]  # fmt: skip

    def command(self, joint: str, value: float) -> None:
        """Take a command, which stands until another comes."""
        if math.isfinite(value):
            self._commands[self._robot.joints.index(joint)] = value

    def halt(self) -> None:
        """Stand still at once, as in a protective stop."""
        if self._robot.interface == "effort":
            self._halted = self.position.copy()
        else:
            self._commands = self.position.copy() if self._robot.interface == "position" else 0.0 * self._commands

    def step(self, dt: float) -> None:
        """Let time pass."""
        before = self.position.copy()
        if self._halted is not None:
            self.velocity *= 0.0
            self.effort = np.full(len(self.position), GRAVITY)
        elif self._robot.interface == "position":
            self.position += (self._commands - self.position) * (1.0 - math.exp(-dt / POSITION_S))
            self.velocity = (self.position - before) / dt
            self.effort = GRAVITY + DAMPING * self.velocity
        elif self._robot.interface == "velocity":
            self.velocity += (self._commands - self.velocity) * (1.0 - math.exp(-dt / VELOCITY_S))
            self.position += self.velocity * dt
            self.effort = GRAVITY + DAMPING * self.velocity
        else:
            self.effort = np.clip(self._commands, -self._robot.most_effort, self._robot.most_effort)
            self.velocity += (self.effort - GRAVITY - DAMPING * self.velocity) / INERTIA * dt
            self.position += self.velocity * dt


class Driver:
    """Joint states, the robot's description, and the faults that both can have."""

    def __init__(self, robot: Robot, plant: Plant) -> None:
        self._robot, self._plant = robot, plant
        self.node = Node("robot", namespace=robot.namespace)
        self.node.declare_parameter("fault", "none")
        self.node.add_on_set_parameters_callback(self._on_parameters)
        kept = ReliabilityPolicy.BEST_EFFORT if robot.best_effort else ReliabilityPolicy.RELIABLE
        quality = QoSProfile(depth=10, reliability=kept)
        self._states = self.node.create_publisher(JointState, "joint_states", quality)
        self._random = np.random.default_rng(0)
        self.fault = "none"
        self._frozen: np.ndarray | None = None
        self._since = 0.0
        self._last: JointState | None = None
        self._waiting: deque[tuple[float, JointState]] = deque()
        if robot.description != "none":
            latched = robot.description == "latched"
            kept = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
            self._description = self.node.create_publisher(
                String, "robot_description", QoSProfile(depth=1, durability=kept)
            )
            self._description.publish(String(data=self._urdf()))

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            self.fault, self._since = str(parameter.value), time.monotonic()
            self._robot.active = self.fault not in ("inactive", "halt")
            if self.fault == "halt":
                self._plant.halt()
        return SetParametersResult(successful=True)

    def _urdf(self) -> str:
        r = self._robot
        limit = f'<limit lower="{-r.limit}" upper="{r.limit}" velocity="{r.speed}" effort="{r.most_effort}"/>'
        joints = "".join(f'<joint name="{j}" type="{r.kind}">{limit}{r.extra}</joint>' for j in r.joints)
        return f'<robot name="r">{joints}</robot>'

    def publish(self) -> None:
        """The joints as the robot says they are."""
        r, p = self._robot, self._plant
        if self.fault == "stop":
            return
        read = np.stack([p.position, p.velocity, p.effort])
        read += NOISE * self._random.standard_normal(read.shape)
        if r.wraps:
            read[0] = np.remainder(read[0] + math.pi, math.tau) - math.pi
        self._frozen = (read if self._frozen is None else self._frozen) if self.fault == "freeze" else None
        read = read if self._frozen is None else self._frozen
        if self.fault == "nan":
            read = read * math.nan
        elif self.fault == "jump":
            read = read + np.array([[0.3], [0.0], [0.0]])
        elif self.fault == "wrap":
            read = read - np.array([[math.tau], [0.0], [0.0]])
        names = r.joints if self.fault != "lose_joint" else r.joints[:1]
        message = JointState(name=names)
        stamp = self.node.get_clock().now()
        message.header.stamp = (stamp + CLOCK_STEP if self.fault == "time_jump" else stamp).to_msg()
        message.position, message.velocity = (read[k, : len(names)].tolist() for k in (0, 1))
        if r.efforts:
            message.effort = read[2, : len(names)].tolist()
        if self.fault == "repeat":
            message = self._last or message
        self._last = message
        self._waiting.append((time.monotonic(), message))
        late = min(LATE_S, 0.5 * (time.monotonic() - self._since)) if self.fault == "late" else 0.0
        while self._waiting and time.monotonic() - self._waiting[0][0] >= late:
            self._states.publish(self._waiting.popleft()[1])


def main() -> None:
    """Run the robot until the process is ended."""
    robot = Robot(**json.loads(sys.argv[1]))
    with suppress(OSError):  # a robot does not wait for the computer of its user
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    rclpy.init()
    plant = Plant(robot)
    driver, controller = Driver(robot, plant), Controller(robot, plant)
    executor = SingleThreadedExecutor()
    executor.add_node(driver.node)
    executor.add_node(controller.node)
    gc.collect()
    gc.freeze()  # a collection would hold both threads up for a third of a second
    # The drives have a thread of their own: who publishes to a process that is stopped may be held up with it.
    threading.Thread(target=drive, args=(plant, Path(robot.truth)), daemon=True).start()
    period = 1.0 / robot.rate_hz
    published = time.monotonic()
    while rclpy.ok():
        executor.spin_once(timeout_sec=0.5 * period)
        now = time.monotonic()
        if now - published >= period:
            published = max(published + period, now - 5.0 * period)
            driver.publish()


def drive(plant: Plant, path: Path) -> None:
    """Let time pass for the joints, and write down what they do."""
    before = time.monotonic()
    with path.open("w", buffering=1) as truth:
        while True:
            time.sleep(STEP_S)
            now = time.monotonic()
            plant.step(min(now - before, LONGEST_STEP_S))
            before = now
            row = [*plant.position, *plant.velocity, *plant.effort]
            truth.write(f"{now:.6f} " + " ".join(f"{float(value):.7g}" for value in row) + "\n")


if __name__ == "__main__":
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        main()
    rclpy.try_shutdown()
