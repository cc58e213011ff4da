"""Node `chirp_exciter`: moves one joint along a chirp, the others held, and records the run as a rosbag2."""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Sequence

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from flex_ident.commands.common import one_line
from flex_ident.errors import FlexIdentError, UsageError
from flex_ident.excitation import Output
from flex_ident.excitation.run import Run
from flex_ident.excitation.surroundings import Surroundings
from flex_ident.nodes.allowed_paths import refuse_outside
from flex_ident.nodes.command_clock import AROUND, real_time, threads_in_real_time
from flex_ident.nodes.command_messages import command_messages
from flex_ident.nodes.command_topic import CommandTopic, publishers
from flex_ident.nodes.commander import Commander
from flex_ident.nodes.controller_parameters import ControllerParameters
from flex_ident.nodes.exciter_recording import RunRecording
from flex_ident.nodes.exciter_settings import USAGE, Experiment, declare_all, experiment
from flex_ident.nodes.exciter_state import StateReports
from flex_ident.nodes.joint_messages import JOINT_STATE
from flex_ident.nodes.joint_samples import joint_sample
from flex_ident.nodes.message_types import definition_and_digest
from flex_ident.nodes.robot_description import RobotDescription, exciter_within
from flex_ident.nodes.running import run_node
from flex_ident.nodes.transports import share_no_memory

HOUSEKEEPING_S = 0.1
SWITCH_S = 2e-4
"""How long one thread may keep another from running: Python's 5 ms would be the jitter of the commands."""


class ChirpExciter(Node):
    """Hands what comes to the run and publishes what it returns, from a thread with a steady clock.

    The lock guards the run, which joint states, services and ticks reach from two threads.
    """

    def __init__(self) -> None:
        with threads_in_real_time(AROUND):  # those of DDS
            super().__init__("chirp_exciter")
        declare_all(self)
        self._lock = threading.RLock()
        self._given = self._experiment = experiment(self)
        self._directory = str(self._experiment.values["recording.directory"])
        values = self._experiment.values
        exciter, self._limits_problem = exciter_within(self._experiment, None)
        self._outdated = False  # whether the limits are of an earlier description: another came while the joint moved
        self.run = Run(exciter, values["auto_start"], values["exit_when_done"], time.monotonic())
        self._commands = CommandTopic(self, values)
        self._controller = ControllerParameters(self, self._commands.name)
        self._commander = Commander(self, self._commands, self._step, lambda *written: self._recording.write(*written))
        self._reports = StateReports(self)
        self._states_topic, self._states_type = self.resolve_topic_name("joint_states"), ""
        self._recording = RunRecording(self, (self._states_topic, self._commander.topic))
        definition_and_digest(JOINT_STATE)  # now, not while a robot waits
        self._description = RobotDescription(self, self._on_description)
        self.create_service(Trigger, "~/start", self._on_start)
        self.create_service(Trigger, "~/stop", self._on_stop)
        self.create_timer(HOUSEKEEPING_S, self._housekeeping, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.add_on_set_parameters_callback(self._on_parameters)
        self._publish_state()

    def _take(self, found: Experiment) -> None:
        with self._lock:
            self._outdated = False
            self._given, self._experiment = found, Experiment(self._controller.completed(found.values))
            exciter, self._limits_problem = exciter_within(self._experiment, self._description.text)
            self.run.take(exciter)

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take changes while nothing moves; refuse what is wrong."""
        try:
            with self._lock:
                if why := self.run.busy_with():
                    raise UsageError(why)
                if any(p.type_ == Parameter.Type.NOT_SET for p in parameters):
                    raise UsageError("a parameter cannot be deleted: set it to its default.")
                found = experiment(self, parameters)
                refuse_outside(str(found.values["recording.directory"]), self._directory, what="recording.directory")
                self._take(found)
        except FlexIdentError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _on_description(self) -> None:
        with self._lock:
            self._outdated = self.run.busy
            if self.run.phase == "moving":
                self.run.stop(f"{self._description.topic} has changed")
            if not self._outdated:
                self._take(self._given)
        if self._limits_problem:
            self.get_logger().warning(self._limits_problem)

    def _on_start(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self._outdated and not self.run.busy:
            self._take(self._given)
            why = f"{self._description.topic} has changed, and its limits with it: call again."
        else:
            with self._lock:
                why = self.run.request(time.monotonic(), self._surroundings())
            why = why or self._open()
        unseen = self._recording.unpublished
        begun = (
            f"moving to the start position; recording to {self._recording.path or 'nowhere'}; {self._commands.guard}",
            f"not received so far: {unseen}" if unseen else "", self._controller.advice(self._experiment.values),
        )  # fmt: skip
        response.success, response.message = not why, why or "; ".join(filter(None, begun))
        return response

    def _on_stop(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            response.success, response.message = self.run.stop("stopped by ~/stop")
        return response

    def _surroundings(self) -> Surroundings:
        """What is seen around the node now."""
        values = self._experiment.values
        self._controller.look()
        listeners = self._commands.listeners()
        guard_problem = self._commands.guard.problem(
            moving=self.run.phase == "moving", listeners=listeners, feedback=values["command.interface"] == "effort"
        )
        return Surroundings(
            self._commands.name, self._states_topic, self._description.topic,
            listeners=listeners, others=self._commands.others(),
            states_published=bool(self._states_type), states_publishers=publishers(self, self._states_topic),
            description=self._description.state(),
            description_required=bool(values["limits.require_urdf"]),
            open_limits=self._experiment.open_limits, limits_problem=self._limits_problem,
            controller_problem=self._controller.problem(values),
            records=bool(values["recording.directory"]) and values["recording.require_effort"],
            recording_failure=self._recording.failure, guard_problem=guard_problem,
        )  # fmt: skip

    def _open(self) -> str:
        """Open the recording, from when the next joint state begins the motion; why that cannot be."""
        try:
            self._recording.open(self._experiment.values, self.run.exciter.limits)
        except FlexIdentError as error:
            with self._lock:
                self.run.not_opened(time.monotonic(), str(error))
            return str(error)
        with self._lock:
            self.run.opened(time.monotonic())
        if advice := self._controller.advice(self._experiment.values):
            self.get_logger().warning(advice)
        return ""

    def _on_state(self, data: bytes) -> None:
        now, ros_now = time.monotonic(), 1e-9 * self.get_clock().now().nanoseconds
        self._recording.write(self._states_topic, data)
        with self._lock:
            settings = self.run.exciter.settings
            try:
                sample = joint_sample(data, settings.joint, settings.held, now, ros_now)
            except Exception as error:  # whatever rclpy makes of bytes that are no joint state
                why = f"a message on {self._states_topic} is no joint state ({one_line(error)})"
                self.run.exciter.stop(why)
                self.get_logger().warning(why, throttle_duration_sec=1.0)
                return
            if self.run.observe(sample, self._limits_problem):
                values = self._experiment.values
                self._commander.start(command_messages(values), settings.joint, float(values["rate_hz"]))

    def _housekeeping(self) -> None:
        """Find topics, have the run look around, open and close its recording, publish the state."""
        if not self._states_type:
            self._states_type = self._recording.raw.subscribe(self._states_topic, self._on_state, urgent=True)
        self._recording.find_topics()
        self._controller.look()
        with self._lock:
            if not self.run.busy and self._controller.completed(self._given.values) != self._experiment.values:
                self._take(self._given)
            self.run.watch(time.monotonic(), self._surroundings)
        if self.run.phase == "opening":
            self._open()
        self._publish_state()
        if why := self._commander.error:
            with self._lock:
                self.run.cannot_command(why)
        if self.run.phase == "closing" and not self._commander.ticking:
            self._close()
        self._reports.say(self.run.notes())

    def _close(self) -> None:
        """Close the recording, say how it went, and end if asked to."""
        if punctuality := self._commander.finish():
            self.get_logger().info(punctuality)
        failure = self._recording.close()
        with self._lock:
            self.run.closed(failure)
        self._publish_state()

    def _publish_state(self) -> None:
        with self._lock:
            report = self.run.report()
        self._reports.publish(self.run.exciter.settings.joint, *report, str(self._recording.path or ""))

    def _step(self, now: float) -> Output:
        with self._lock:
            return self.run.step(now)

    def interrupt(self, why: str) -> None:
        """Ramp down if anything moves, then end."""
        with self._lock:
            self.run.interrupt(why)
        self._reports.say(self.run.notes())

    def say_goodbye(self) -> None:
        """See to it that the last state has come to all who listen: it would be lost with the process."""
        if not self._reports.delivered():
            self.get_logger().warning("somebody who listens to ~/state or /diagnostics has not taken the last one")

    def end(self) -> None:
        """Ramp down what still moves and close the bag, whatever state they are in."""
        with self._lock:
            self.run.stop("the node ends")
        self._commander.end()
        self._recording.raw.stop()
        self._commands.guard.end()
        self._recording.close()


def main(arguments: list[str] | None = None) -> int:
    """The console script; returns the exit status: 0 done, 2 configuration, 3 refused or aborted."""

    def run(node: ChirpExciter, asked: Sequence[str]) -> int:
        real_time(AROUND)
        sys.setswitchinterval(SWITCH_S)
        gc.collect()
        gc.freeze()  # what is there stays: collections while a robot moves are short
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        try:
            while not node.run.ending:
                executor.spin_once(timeout_sec=HOUSEKEEPING_S)
                if asked:
                    node.interrupt(f"stopped by {asked[0]}")
            node.say_goodbye()
        finally:
            node.end()
        return node.run.status

    share_no_memory()
    return run_node(USAGE, ChirpExciter, run, arguments)
