"""Node `simulated_joint`: a virtual robot joint that takes the commands and publishes the topics of a robot."""

from __future__ import annotations

import gc
import math
import sys
import threading
import time
from array import array
from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory

from flex_ident.errors import ConfigurationError
from flex_ident.nodes.command_clock import AROUND, real_time, threads_in_real_time
from flex_ident.nodes.raw_topics import Polled
from flex_ident.nodes.running import run_node, spin
from flex_ident.nodes.simulated_settings import (
    FAULT,
    HELD_AT,
    USAGE,
    declared_values,
    description_of,
    drive_of,
    instruments_of,
    joint_names,
)
from flex_ident.nodes.trajectory import TrajectoryCommand
from flex_ident.nodes.transports import share_no_memory
from flex_ident.virtual_joint import Measurement, VirtualJoint

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
QUEUE = 2000
LONGEST_DELAY_S = 1.0
"""When the machine stood still for longer, the joint stood still as well; below, late samples are made up for."""
LATE_TICKS = 3.0
"""Samples from which the joint is late: each command is then taken when it was sent, not when it is looked at."""
STOOD_S, STREAM_S = 0.02, 0.1
"""By how much longer than it sleeps a process takes that stood still, and how dense a stream of commands is."""
ARRIVAL_S, LOOK_S = 0.3, 1e-3
"""How long commands may take that were sent meanwhile, and how often they are looked for."""
JUMP_NS = 5_000_000_000
WARN_EVERY_S = 1.0
LONGEST_SLEEP_S = 0.1
"""However slowly the joint's time runs, it is asked to end."""
LONGEST_END_S = 5.0
"""How long a sample may take when the node ends: what it publishes by must not be taken down under it."""
STOPPED = 3


class SimulatedJoint(Node):
    """Steps the virtual joint in its own thread by a steady clock; a late tick catches up, so that data stay exact."""

    def __init__(self) -> None:
        with threads_in_real_time(AROUND):  # those of DDS: a robot does not wait for the computer of its user
            super().__init__("simulated_joint")
        self._values, self.model = declared_values(self)
        self.names, self._commanded = joint_names(self, self._values)
        v = self._values
        self._joint = VirtualJoint(
            self.model, rate_hz=float(v["rate_hz"]), drive=drive_of(self.model, v), instruments=instruments_of(v),
            seed=int(float(v["seed"])), start=float(v["start_position"]),
        )  # fmt: skip
        self._command = self._joint.command
        self._trajectory: TrajectoryCommand | None = None
        self._waiting: deque[tuple[Any, dict[str, int]]] = deque()
        self._sent_ns = 0
        """When the latest command that has arrived was sent, of the system's clock."""
        self._states = self.create_publisher(JointState, "joint_states", QUEUE)
        self._links = None
        if v["link_encoder"] and not self.model.rigid:
            self._links = self.create_publisher(JointState, "link_joint_states", QUEUE)
        self._description = self.create_publisher(String, "robot_description", LATCHED)
        self._description.publish(String(data=description_of(self.names, v)))
        forward = v["controller.type"] == "forward_command"
        self._take = self._take_forward if forward else self._take_trajectory
        self._commands = self.create_subscription(
            Float64MultiArray if forward else JointTrajectory, str(v["controller.topic"]), self._take, QUEUE,
            callback_group=Polled(),
        )  # fmt: skip
        self._fault = str(v["fault"])
        self.add_on_set_parameters_callback(self._checked)
        self.add_post_set_parameters_callback(self._on_parameters)
        self._stopping = threading.Event()
        self.status = 0
        self._thread = threading.Thread(target=self._run, daemon=True)

    def begin(self) -> None:
        """Let time pass, in real time where that is wanted: a robot does not wait for the computer of its user."""
        if float(self._values["speed"]) <= 1.0:
            real_time(AROUND)
        self._thread.start()
        self.get_logger().info(
            f"{self.names[0]}: a virtual joint at {self._values['rate_hz']:.0f} Hz, commands on "
            f"{self._values['controller.topic']} ({self._joint.drive.interface})"
        )

    def end(self) -> None:
        """Stop the clock."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(LONGEST_END_S)

    def _checked(self, parameters: list[Parameter]) -> SetParametersResult:
        try:
            for parameter in parameters:
                if parameter.name == FAULT.key:
                    FAULT.checked(parameter.value, self.get_name())
        except ConfigurationError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _on_parameters(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == FAULT.key:
                self._fault = str(parameter.value)

    # -- what comes in

    def _collect(self) -> None:
        """Have what has arrived wait."""
        with self._commands.handle:
            while (taken := self._commands.handle.take_message(self._commands.msg_type, False)) is not None:
                self._waiting.append(taken)
                self._sent_ns = taken[1]["source_timestamp"]

    def _await_commands(self, gap: float) -> None:
        """After this process stood still for `gap` s: wait for what was sent meanwhile, which arrives in order.

        What the middleware has yet to deliver would else come after the samples for which it was meant: a jump.
        """
        now_ns, end = time.time_ns(), time.monotonic() + ARRIVAL_S
        if now_ns - self._sent_ns > (gap + STREAM_S) * 1e9:
            return  # nobody was commanding
        while self._sent_ns < now_ns and time.monotonic() < end and not self._stopping.is_set():
            time.sleep(LOOK_S)
            self._collect()

    def _arrived(self, before_ns: float) -> Iterator[Any]:
        """Commands sent before that instant of the system's clock that have not been taken yet."""
        self._collect()
        while self._waiting and self._waiting[0][1]["source_timestamp"] <= before_ns:
            yield self._waiting.popleft()[0]

    def _ignored(self, why: str) -> None:
        self.get_logger().warning(f"command ignored: {why}", throttle_duration_sec=WARN_EVERY_S)

    def _take_forward(self, message: Float64MultiArray) -> None:
        if len(message.data) != len(self._commanded):
            self._ignored(f"{len(message.data)} numbers for {len(self._commanded)} joints.")
            return
        value = message.data[self._commanded.index(self.names[0])]
        if not math.isfinite(value):
            self._ignored(f"{value} is not a finite number.")
            return
        self._command = value

    def _take_trajectory(self, message: JointTrajectory) -> None:
        if self.names[0] not in message.joint_names or not message.points:
            self._ignored(f"a trajectory of {len(message.points)} points for {', '.join(message.joint_names)}.")
            return
        self._trajectory = TrajectoryCommand(message, self.names[0], self._joint.time, self._command)

    # -- what goes out

    def _run(self) -> None:
        try:
            self._live()
        except Exception as error:
            if self._stopping.is_set() or not self.context.ok():
                return  # the context was shut down between two samples
            print(f"simulated_joint: stopped ({type(error).__name__}: {error})", file=sys.stderr)
            self.status = STOPPED
            self.context.try_shutdown()

    def _live(self) -> None:
        """Step as many samples as time demands; stamps are the samples' own instants, however late they leave."""
        pace = float(self._values["rate_hz"]) * float(self._values["speed"])
        begin = time.monotonic()
        origin = self.get_clock().now().nanoseconds
        outgoing = Outgoing(self.names, self._states, self._links)
        done, looked = 0, time.monotonic()
        while not self._stopping.is_set():
            gap, looked = time.monotonic() - looked, time.monotonic()
            if gap > LONGEST_SLEEP_S + STOOD_S:
                self._await_commands(gap)
            late = time.monotonic() - begin - (done + 1) / pace
            if late < 0.0:
                time.sleep(min(-late, LONGEST_SLEEP_S))
                continue
            if late > LONGEST_DELAY_S:
                begin += late
                origin += round(late * 1e9)
                self.get_logger().warning(f"the machine stood still for {late:.1f} s, and the joint with it.")
            catching_up = late > LATE_TICKS / pace and late <= LONGEST_DELAY_S
            for message in self._arrived(time.time_ns() - 1e9 * late if catching_up else math.inf):
                self._take(message)
            if self._trajectory is not None:
                self._command = self._trajectory.at(self._joint.time)
            measured = self._joint.step(self._command)
            outgoing.publish(measured, origin + round(measured.time * 1e9), self._fault)
            done += 1


class Outgoing:
    """Messages made once and filled for every sample, and the faults that they can have."""

    def __init__(self, names: list[str], states: Any, links: Any) -> None:
        self._states, self._links = states, links
        self._whole = _message(names, len(names))
        self._without = _message(names[1:], len(names) - 1)
        self._link = _message(names[:1], 1)
        self._frozen: Measurement | None = None

    def publish(self, measured: Measurement, stamp_ns: int, fault: str) -> None:
        """Publish one sample as `fault` has it."""
        if fault == "stop":
            return
        self._frozen = (self._frozen or measured) if fault == "freeze" else None
        shown = self._frozen or measured
        seconds, rest = divmod(stamp_ns + (JUMP_NS if fault == "time_jump" else 0), 1_000_000_000)
        message = self._without if fault == "lose_joint" else self._whole
        message.header.stamp.sec, message.header.stamp.nanosec = seconds, rest
        if message is self._whole:
            message.position[0] = math.nan if fault == "nan" else shown.motor_position
            message.velocity[0] = shown.motor_velocity
            message.effort[0] = shown.motor_torque
        self._states.publish(message)
        if self._links is not None and fault != "lose_joint":
            self._link.header.stamp = message.header.stamp
            self._link.position[0] = shown.link_position
            self._links.publish(self._link)


def _message(names: list[str], joints: int) -> JointState:
    still = array("d", [0.0] * joints)
    return JointState(name=names, position=array("d", [HELD_AT] * joints), velocity=still, effort=array("d", still))


def main(arguments: list[str] | None = None) -> int:
    """The console script; returns the exit status: 0 stopped by a signal, 2 configuration, 3 the joint failed."""

    def run(node: SimulatedJoint, asked: Sequence[str]) -> int:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        gc.collect()
        gc.freeze()  # collections while the joint moves are short
        node.begin()
        try:
            spin(executor, asked)
        finally:
            node.end()
        return node.status

    share_no_memory()
    return run_node(USAGE, SimulatedJoint, run, arguments)
