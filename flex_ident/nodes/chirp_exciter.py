"""Node `chirp_exciter`: moves one joint along a chirp, the others held, and records the run as a rosbag2."""

from __future__ import annotations

import json
import math
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from flex_ident import __version__
from flex_ident.errors import ConfigurationError, FlexIdentError, UsageError
from flex_ident.excitation import Exciter, JointSample, Output, chirp_reference
from flex_ident.excitation.exciter import MOVING
from flex_ident.excitation.limits import urdf_limits
from flex_ident.nodes.declared import current, declare
from flex_ident.nodes.exciter_settings import LISTS, SETTINGS, chirp_of, exciter_of, limits_of
from flex_ident.nodes.recorder import Recorder, message_class, unique_folder
from flex_ident.nodes.running import run_node, topic_type

JOINT_STATE = "sensor_msgs/msg/JointState"
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
READY_S = 5.0
"""Time in which joint states and a subscriber of the commands must be found before an automatic start gives up."""
LEVELS = {"aborted": DiagnosticStatus.ERROR, "ramping_down": DiagnosticStatus.WARN}
ABORTED = 3


class ChirpExciter(Node):
    """Hands joint states to the exciter's rules and publishes what they return, from a thread with a steady clock."""

    def __init__(self) -> None:
        super().__init__("chirp_exciter")
        declare(self, SETTINGS)
        for name, (text, default) in LISTS.items():
            self.declare_parameter(name, default, ParameterDescriptor(description=text))
        self.values = current(self, SETTINGS)
        v = self.values
        self.exciter = Exciter(exciter_of(v), chirp_reference(chirp_of(v)), limits_of(v))
        self.joint = str(v["joint"])
        self.command_joints = [j for j in self.get_parameter("command.joints").value if j] or [self.joint]
        if self.joint not in self.command_joints:
            raise ConfigurationError(f"command.joints does not hold '{self.joint}'.")
        if v["command.type"] == "joint_trajectory" and v["command.interface"] != "position":
            raise ConfigurationError("command.type joint_trajectory takes command.interface position.")
        self._trajectory = v["command.type"] == "joint_trajectory"
        kind = JointTrajectory if self._trajectory else Float64MultiArray
        self._commands = self.create_publisher(kind, str(v["command.topic"]), 10)
        self._reference = self.create_publisher(JointState, "~/reference", 100)
        self._state = self.create_publisher(DiagnosticStatus, "~/state", LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_service(Trigger, "~/start", self._on_start)
        self.create_service(Trigger, "~/stop", self._on_stop)
        self.create_subscription(String, "/robot_description", self._on_description, LATCHED)
        self.create_timer(0.2, self._housekeeping)
        self._lock = threading.Lock()
        self._described = False
        self._recorder: Recorder | None = None
        self._states_seen = False
        self._pending = False
        self._published_state: tuple[str, str, int] | None = None
        self._ticks: list[float] = []
        self._late = 0
        self._final: Output | None = None
        self._wanted = bool(v["auto_start"])
        self._since = time.monotonic()
        self._stopping = threading.Event()
        self.ending = threading.Event()
        self.status = 0
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._state_subscription: Any = None
        self._bag: Path | None = None

    # -- what comes in

    def _on_description(self, message: String) -> None:
        try:
            limits = urdf_limits(message.data, self.joint)
            with self._lock:
                self.exciter.with_limits(limits)
            self._described = True
        except FlexIdentError as error:
            self.get_logger().warning(str(error))

    def _on_state_bytes(self, data: bytes) -> None:
        now = time.monotonic()
        message = deserialize_message(data, JointState)
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        names = list(message.name)
        self._states_seen = True
        if self.joint not in names:
            sample = JointSample(now, stamp, None)
        else:

            def at(values: Any, name: str) -> float:
                i = names.index(name) if name in names else -1
                return float(values[i]) if 0 <= i < len(values) else math.nan

            others = tuple(at(message.position, j) for j in self.command_joints if j != self.joint)
            sample = JointSample(
                now, stamp if stamp > 0.0 else now, at(message.position, self.joint), at(message.velocity, self.joint),
                at(message.effort, self.joint), others,
            )  # fmt: skip
        with self._lock:
            self.exciter.observe(sample)
        if self._pending and sample.position is not None:
            self._begin(now)

    def _on_start(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        why = self._start()
        response.success = not why
        response.message = why or f"moving to the start position; recording to {self._bag or 'nowhere'}"
        return response

    def _on_stop(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self._lock:
            why = self.exciter.stop(time.monotonic(), "stopped by ~/stop")
        response.success = not why
        response.message = why or "ramping down"
        return response

    # -- start and end

    def _readiness(self) -> str:
        """Why nothing can move yet, on the ROS side; empty when all is there."""
        if self.values["limits.require_urdf"] and not self._described:
            return "no /robot_description has arrived, and limits.require_urdf is true."
        if self._commands.get_subscription_count() == 0:
            return f"nobody listens on {self._commands.topic_name}: is the controller active?"
        if not self._states_seen:
            return "no joint states arrive: check the topic and that the robot's driver runs."
        return ""

    def _start(self) -> str:
        why = "already starting: wait for ~/state." if self._pending else self._readiness()
        if not why:
            with self._lock:
                why = self.exciter.objection(time.monotonic())
        if why:
            return why
        try:
            self._open_recorder()
        except FlexIdentError as error:
            return str(error)
        self._pending = True  # opening the bag took a while: begin with the next joint state
        return ""

    def _begin(self, now: float) -> None:
        """Begin to move, all checks passed again on a fresh joint state."""
        self._pending = False
        with self._lock:
            why = self.exciter.start(now)
        if why:
            self._close_recorder()
            self._give_up(why)
        elif not self._thread.is_alive():
            self._thread.start()

    def _open_recorder(self) -> None:
        directory = str(self.values["recording.directory"])
        if not directory:
            return
        stem = f"{self.joint}_{time.strftime('%Y%m%d_%H%M%S')}".replace("/", "_")
        self._bag = unique_folder(Path(directory).expanduser(), stem)
        limits = self.exciter.limits
        information = {
            "flex_ident_version": __version__,
            "flex_ident_parameters": json.dumps({**self.values, "recording.topics": self._topics()}),
            "flex_ident_limits": json.dumps({k: str(v) for k, v in vars(limits).items()}),
        }
        recorder = Recorder(self, self._bag, storage=str(self.values["recording.storage"]), information=information)
        recorder.add("joint_states", JOINT_STATE)
        self._reference_name = recorder.add(self._reference.topic_name, JOINT_STATE)
        for topic in self._topics():
            kind = topic_type(self, self.resolve_topic_name(topic))
            if kind:
                recorder.subscribe(topic, kind)
        self._recorder = recorder

    def _topics(self) -> list[str]:
        return [str(t) for t in self.get_parameter("recording.topics").value if t]

    def _close_recorder(self) -> None:
        if self._recorder is not None:
            self._recorder.close()

    def _housekeeping(self) -> None:
        """Find the joint states, start when asked to, watch recorder and subscribers, publish state and diagnostics."""
        now = time.monotonic()
        self._subscribe_states()
        with self._lock:
            state = self.exciter.state
            if state in MOVING:
                if self._recorder is not None and self._recorder.failure:
                    self.exciter.stop(now, self._recorder.failure)
                elif self._commands.get_subscription_count() == 0:
                    self.exciter.stop(now, f"nobody listens on {self._commands.topic_name} any more")
        if self._wanted and state == "idle":
            why = self._start()
            if not why:
                self._wanted = False
            elif now - self._since > READY_S:
                self._wanted = False
                self._give_up(why)
        self._publish_state(now)
        if state in ("done", "aborted") and not self._thread.is_alive() and self._final is not None:
            self._finish()

    def _subscribe_states(self) -> None:
        if self._state_subscription is not None:
            return
        name = self.resolve_topic_name("joint_states")
        if not self.get_publishers_info_by_topic(name):
            return
        reliable = all(int(p.qos_profile.reliability) == 1 for p in self.get_publishers_info_by_topic(name))
        qos = QoSProfile(depth=2000, reliability=1 if reliable else 2)

        def received(data: bytes) -> None:
            self._on_state_bytes(data)
            if self._recorder is not None:
                self._recorder.write(name, data)

        self._state_subscription = self.create_subscription(message_class(JOINT_STATE), name, received, qos, raw=True)

    def _give_up(self, why: str) -> None:
        self.get_logger().error(f"refused: {why}")
        self.exciter.reason = why
        if self.values["exit_when_done"]:
            print(f"chirp_exciter: {why}", file=sys.stderr)
            self.status = ABORTED
            self.ending.set()

    def interrupt(self, why: str) -> None:
        """SIGINT or SIGTERM: ramp down, then end."""
        with self._lock:
            moving = self.exciter.state in MOVING
            if moving:
                self.exciter.stop(time.monotonic(), why)
        self.values["exit_when_done"] = True
        if not moving:
            self.ending.set()

    # -- what goes out

    def _run(self) -> None:
        """Tick by a steady clock; a late tick skips, it never stretches the chirp."""
        period = 1.0 / float(self.values["rate_hz"])
        begin = time.monotonic()
        k = 0
        while not self._stopping.is_set():
            due = begin + k * period
            wait = due - time.monotonic()
            if wait > 0.0:
                time.sleep(wait)
            now = time.monotonic()
            if self.exciter.state == "exciting":
                self._ticks.append(now - due)
            skipped = int((now - due) / period)
            self._late += skipped
            k += 1 + skipped
            with self._lock:
                output = self.exciter.step(now)
            try:
                self._publish(output, period)
            except Exception as error:  # the context went away
                with self._lock:
                    self.exciter.stop(now, f"commands cannot be published ({error})")
                if self.exciter.state not in MOVING:
                    break
            self._final = output
            if output.state in ("done", "aborted"):
                break

    def _publish(self, output: Output, period: float) -> None:
        if output.command is not None:
            others = iter(output.others)
            row = [
                output.command if j == self.joint else self._held(next(others, math.nan)) for j in self.command_joints
            ]
            if self._trajectory:
                point = JointTrajectoryPoint(positions=row)
                point.time_from_start.nanosec = int(period * 1e9)
                self._commands.publish(JointTrajectory(joint_names=self.command_joints, points=[point]))
            else:
                self._commands.publish(Float64MultiArray(data=row))
        message = JointState(name=[self.joint], position=[output.position], velocity=[output.velocity])
        message.header.stamp = self.get_clock().now().to_msg()
        self._reference.publish(message)
        if self._recorder is not None:
            self._recorder.write(self._reference_name, serialize_message(message))

    def _held(self, position: float) -> float:
        """What a joint that holds is commanded: its position, or no speed, or no effort."""
        if self.values["command.interface"] != "position":
            return 0.0
        if not math.isfinite(position):
            raise UsageError("a joint that shall hold has no position: check command.joints.")
        return position

    def _publish_state(self, now: float) -> None:
        with self._lock:
            state, reason = self.exciter.state, self.exciter.reason
        progress = self._final.progress if self._final is not None else 0.0
        text = f"{state}: {reason}" if reason else state
        status = DiagnosticStatus(
            level=LEVELS.get(state, DiagnosticStatus.OK), name=f"chirp_exciter: {self.joint}", message=text,
            hardware_id=self.joint,
            values=[
                KeyValue(key="state", value=state), KeyValue(key="reason", value=reason),
                KeyValue(key="progress_percent", value=f"{100 * progress:.0f}"),
                KeyValue(key="bag", value=str(self._bag or "")),
            ],
        )  # fmt: skip
        mark = (state, reason, int(100 * progress))
        if mark != self._published_state:
            self._published_state = mark
            self._state.publish(status)
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)

    def _finish(self) -> None:
        """Close the bag, say how it went, and end if asked to."""
        output, self._final = self._final, None
        assert output is not None
        recorder = self._recorder
        self._close_recorder()
        self._published_state = None
        lines = [self.timing()]
        if recorder is not None:
            lines.append(f"recorded {recorder.messages} messages to {self._bag}, {recorder.lost} lost")
            if recorder.failure:
                lines.append(recorder.failure)
        for line in lines:
            self.get_logger().info(line)
        if output.state == "aborted":
            self.get_logger().error(f"aborted: {output.reason}")
        if self.values["exit_when_done"]:
            if output.state == "aborted":
                print(f"chirp_exciter: aborted: {output.reason}", file=sys.stderr)
                self.status = ABORTED
            self.ending.set()
        else:
            self._recorder = None
            self._thread = threading.Thread(target=self._run, daemon=True)

    def timing(self) -> str:
        """Achieved rate and jitter of the commands while exciting, in words."""
        if len(self._ticks) < 2:
            return "no commands were timed"
        late = 1e6 * np.array(self._ticks)
        p50, p99 = np.percentile(late, (50, 99))
        return (
            f"{len(late)} commands at {self.values['rate_hz']:.0f} Hz, {self._late} skipped; late by {p50:.0f} us "
            f"(median), {p99:.0f} us (99 %), {late.max():.0f} us (most)"
        )

    def end(self) -> None:
        """Stop the thread and close the bag, whatever state they are in."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(1.0)
        self._close_recorder()


def main(arguments: list[str] | None = None) -> int:
    """The console script; returns the exit status: 0 done, 2 configuration, 3 refused or aborted."""

    def run(node: ChirpExciter) -> int:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda n, _frame: node.interrupt(f"stopped by {signal.Signals(n).name}"))
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        try:
            while not node.ending.is_set():
                executor.spin_once(timeout_sec=0.1)
            executor.spin_once(timeout_sec=0.1)
            time.sleep(0.1)  # the last state leaves before the context does
        except ExternalShutdownException:
            pass
        finally:
            node.end()
        return node.status

    return run_node("chirp_exciter", ChirpExciter, run, arguments, own_signals=True)


if __name__ == "__main__":
    sys.exit(main())
