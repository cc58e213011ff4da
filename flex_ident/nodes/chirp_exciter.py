"""Node `chirp_exciter`: moves one joint along a chirp, the others held, and records the run as a rosbag2."""

from __future__ import annotations

import gc
import json
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from flex_ident import __version__
from flex_ident.commands.common import one_line
from flex_ident.errors import FlexIdentError, UsageError
from flex_ident.excitation import Exciter, Output
from flex_ident.excitation.exciter import MOVING
from flex_ident.excitation.limits import urdf_limits
from flex_ident.nodes.command_clock import CommandClock, Punctuality, RosTime
from flex_ident.nodes.exciter_settings import JOINTS, TOPICS, USAGE, Experiment, declare_all, experiment
from flex_ident.nodes.exciter_state import LATCHED, StateReports
from flex_ident.nodes.joint_messages import JOINT_STATE, CommandMessages, ReferenceMessages, joint_sample
from flex_ident.nodes.message_types import definition_and_digest
from flex_ident.nodes.recorder import RawTopics, Recorder, opened_recorder
from flex_ident.nodes.running import quick_executor, run_node

READY_S, PATIENCE_S = 30.0, 3.0
"""Time after which an automatic start gives up: while something has yet to appear, and while the robot objects."""
RAMP_S = 5.0
"""Time in which a joint that still moves when the node ends must have come to rest."""
BEGIN_S = 1.0
"""Time in which a joint state must come after ~/start."""
DISCOVERY_S = 2.0
"""Time that others get to be found, before what is missing is said."""
HOUSEKEEPING_S = 0.1
SWITCH_S = 2e-4
"""How long one thread may keep another from running: Python's 5 ms would be the jitter of the commands."""
ABORTED = 3


class ChirpExciter(Node):
    """Hands joint states to the exciter's rules and publishes what they return, from a thread with a steady clock.

    The lock guards the rules, which joint states, services and ticks reach from two threads.
    """

    def __init__(self) -> None:
        super().__init__("chirp_exciter")
        declare_all(self)
        self._lock = threading.RLock()
        self._description: str | None = None
        self._outdated = False
        """Whether the limits are of an earlier description, as another came while the joint was busy."""
        self._take(experiment(self))
        values = self._experiment.values
        self._commands = self.create_publisher(self._messages().message_class, str(values["command.topic"]), 10)
        self._reference = self.create_publisher(JointState, "~/reference", 100)
        self._reports = StateReports(self)
        self._raw = RawTopics(self)
        self._states_topic = self.resolve_topic_name("joint_states")
        self._states_type = ""
        self._recorder: Recorder | None = None
        self._bag: Path | None = None
        self._clock_thread: CommandClock | None = None
        self._ros_time = RosTime(lambda: int(self.get_clock().now().nanoseconds))
        self._punctuality = Punctuality(float(values["rate_hz"]))
        self._output: Output | None = None
        self._pending_since: float | None = None
        self._refusal = ""
        self._idle_said: str | None = None
        self._wanted = bool(values["auto_start"])
        self._ending_wanted = bool(values["exit_when_done"])
        self._since = time.monotonic()
        self._objected_since: float | None = None
        self.ending = threading.Event()
        self.status = 0
        definition_and_digest(JOINT_STATE)  # now, not while a robot waits
        self.create_subscription(String, "/robot_description", self._on_description, LATCHED)
        self.create_service(Trigger, "~/start", self._on_start)
        self.create_service(Trigger, "~/stop", self._on_stop)
        self.create_timer(HOUSEKEEPING_S, self._housekeeping, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.add_on_set_parameters_callback(self._on_parameters)
        self._publish_state()

    # -- parameters and limits

    def _take(self, found: Experiment) -> None:
        """Take an experiment over, its limits tightened by the URDF; what is wrong with them is kept for ~/start."""
        limits, problem = found.limits, ""
        settings = found.exciter
        if self._description is not None:
            try:
                limits = limits.tightened(urdf_limits(self._description, settings.joint))
                held = tuple(urdf_limits(self._description, j).effort for j in settings.held)
                settings = replace(settings, held_effort=held)
            except FlexIdentError as error:
                problem = str(error)
        with self._lock:
            self._outdated = False
            self._experiment, self._limits_problem = found, problem
            self.exciter = Exciter(settings, found.reference, limits)

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take changes while nothing moves; refuse what is wrong."""
        try:
            with self._lock:
                if self.exciter.state not in MOVING and self._clock_thread is not None:
                    raise UsageError("the recording of the run before is being closed: try again.")
                if self._busy():
                    state = self.exciter.state.replace("_", " ")
                    raise UsageError(f"'{self.exciter.settings.joint}' is {state}: call ~/stop first.")
                if any(p.type_ == Parameter.Type.NOT_SET for p in parameters):
                    raise UsageError("a parameter cannot be deleted: set it to its default.")
                self._take(experiment(self, parameters))
        except FlexIdentError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _on_description(self, message: String) -> None:
        if message.data == self._description:
            return
        self._description = message.data
        with self._lock:
            if self.exciter.state in MOVING:
                self.exciter.stop("/robot_description has changed")
            self._outdated = self._busy()
            if not self._outdated:
                self._take(self._experiment)
        if self._limits_problem:
            self.get_logger().warning(self._limits_problem)

    # -- start and stop

    def _busy(self) -> bool:
        """Whether a run begins, goes on, or has yet to be closed."""
        return self.exciter.state in MOVING or self._pending_since is not None or self._clock_thread is not None

    def _on_start(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        why = self._start()
        response.success = not why
        response.message = why or f"moving to the start position; recording to {self._bag or 'nowhere'}"
        if not why and self._recorder is not None and self._recorder.unpublished:
            response.message += f"; not received so far: {self._recorder.unpublished}"
        return response

    def _on_stop(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self._pending_since is not None:
            self._cancel("stopped by ~/stop before it moved")
            response.success, response.message = True, "nothing had moved yet"
            return response
        with self._lock:
            why = self.exciter.stop("stopped by ~/stop")
        response.success = not why
        response.message = why or "ramping down"
        return response

    def _objection(self) -> str:
        """Why nothing may move yet; empty when it may."""
        if self._outdated and not self._busy():
            self._take(self._experiment)
            return "/robot_description has changed, and its limits with it: call again."
        if self._pending_since is not None:
            return "already starting: wait for ~/state."
        with self._lock:
            if self.exciter.state in MOVING:
                return self.exciter.objection(time.monotonic())
        why = self._unready() or self._limits_problem
        if why:
            return why
        with self._lock:
            return self.exciter.objection(time.monotonic())

    def _unready(self) -> str:
        """What has yet to appear before anything may move; empty when all is there."""
        if self._clock_thread is not None:
            return "the recording of the run before is being closed: call again."
        if self._description is None:
            missing = ", ".join(self._experiment.open_limits)
            if self._experiment.values["limits.require_urdf"]:
                return "no /robot_description has arrived, and limits.require_urdf is true."
            if self.count_publishers("/robot_description"):
                return "/robot_description is announced and has not arrived yet: call again."
            if missing:
                return f"no /robot_description has arrived and {missing} not given: give them, or publish it."
        if self._commands.get_subscription_count() == 0:
            return f"nobody listens on {self._commands.topic_name}: is the controller active?"
        if others := self._other_masters():
            return f"{others} publishes on {self._commands.topic_name} too: only one may command the robot."
        return "" if self._states_type else f"nobody publishes {self._states_topic}: does the robot's driver run?"

    def _other_masters(self) -> str:
        """Names of other nodes that may command the robot; empty when there are none."""
        topic = self._commands.topic_name
        if self.count_publishers(topic) < 2:
            return ""
        names = [i.node_name for i in self.get_publishers_info_by_topic(topic)]
        if self.get_name() in names:
            names.remove(self.get_name())
        return ", ".join(sorted(set(names)))

    def _start(self) -> str:
        """Open the bag and have the next joint state begin the motion; the objection when that must not be."""
        why = self._objection()
        if not why:
            try:
                self._open_recorder()
            except FlexIdentError as error:
                why = str(error)
        if not why:
            self._pending_since, self._refusal = time.monotonic(), ""
        return why

    def _begin(self, now: float) -> None:
        """Begin to move: opening the bag took a while, so all is checked again on a fresh joint state."""
        self._pending_since = None
        with self._lock:
            why = self._limits_problem or self.exciter.start(now)
        if why:
            self._cancel(why)
            return
        values = self._experiment.values
        self._punctuality = Punctuality(values["rate_hz"])
        self._command_messages = self._messages()
        self._reference_messages = ReferenceMessages(self.exciter.settings.joint)
        self._clock_thread = CommandClock(values["rate_hz"], self._tick)
        self._clock_thread.start()

    def _cancel(self, why: str) -> None:
        """Nothing has moved and nothing shall."""
        self._pending_since = None
        if self._recorder is not None:
            self._recorder.close()
            self._recorder = None
        self._give_up(why)

    def _give_up(self, why: str) -> None:
        self._refusal = why
        if self._ending_wanted and self._experiment.values["auto_start"]:
            print(f"chirp_exciter: {why}", file=sys.stderr, flush=True)
            self.status = ABORTED
            self.ending.set()
        else:
            self.get_logger().error(f"refused: {why}")

    def interrupt(self, why: str) -> None:
        """Ramp down if anything moves, then end."""
        self._ending_wanted = True
        with self._lock:
            if self.exciter.state in MOVING:
                self.exciter.stop(why)
                return
        why = f"{why} before it moved"
        if self._pending_since is not None:
            self._cancel(why)
        if self._wanted:
            self._wanted = False
            self._give_up(why)
        if self._clock_thread is None:
            self.ending.set()

    # -- recording

    def _open_recorder(self) -> None:
        values = self._experiment.values
        directory = str(values["recording.directory"])
        self._recorder, self._bag = None, None
        if not directory:
            return
        information = {
            "flex_ident_version": __version__,
            "flex_ident_parameters": json.dumps(values),
            "flex_ident_limits": json.dumps({k: str(v) for k, v in vars(self.exciter.limits).items()}),
        }
        own = (self._states_topic, self._reference.topic_name)
        recorder = opened_recorder(self, Path(directory), values, information, values[TOPICS], own)
        for topic in own:
            recorder.announce(topic, JOINT_STATE)
        recorder.find_topics()
        self._lost_before = self._raw.lost
        self._recorder, self._bag = recorder, recorder.bag.path
        if recorder.unpublished:
            self.get_logger().warning(f"not received so far: {recorder.unpublished}")

    def _on_state(self, data: bytes) -> None:
        now = time.monotonic()
        if self._recorder is not None:
            self._recorder.write(self._states_topic, data)
        settings = self.exciter.settings
        try:
            sample = joint_sample(data, settings.joint, settings.held, now)
        except Exception as error:  # whatever rclpy makes of bytes that are no joint state
            why = f"a message on {self._states_topic} is no joint state ({one_line(error)})"
            with self._lock:
                self.exciter.stop(why)
            self.get_logger().warning(why, throttle_duration_sec=1.0)
            return
        with self._lock:
            self.exciter.observe(sample)
        if self._pending_since is not None and sample.position is not None:
            self._begin(now)

    # -- ten times a second

    def _housekeeping(self) -> None:
        """Find topics, start when asked to, watch recorder and subscribers, publish the state, end the run."""
        now = time.monotonic()
        if not self._states_type:
            self._states_type = self._raw.subscribe(self._states_topic, self._on_state)
        recorder = self._recorder
        if recorder is not None:
            recorder.find_topics()
        with self._lock:
            if self.exciter.state in MOVING:
                if recorder is not None and recorder.bag.failure:
                    self.exciter.stop(recorder.bag.failure)
                elif self._commands.get_subscription_count() == 0:
                    self.exciter.stop(f"nobody listens on {self._commands.topic_name} any more")
                elif others := self._other_masters():
                    self.exciter.stop(f"{others} publishes on {self._commands.topic_name} too")
        if self._pending_since is not None and now - self._pending_since > BEGIN_S:
            self._cancel(f"no joint state with '{self.exciter.settings.joint}' came for {BEGIN_S:g} s after ~/start.")
        if self._wanted:
            self._start_when_ready(now)
        elif now - self._since > DISCOVERY_S:
            self._say_idle()
        self._publish_state()
        if self._clock_thread is not None and not self._clock_thread.ticking:
            self._finish()

    def _say_idle(self) -> None:
        """Say what the node waits for: a call, and what must be there before; again when that changes."""
        with self._lock:
            idle = self.exciter.state == "idle" and not self._busy()
        missing = self._unready() or self._limits_problem
        if idle and missing != self._idle_said:
            self._idle_said = missing
            call = self.resolve_service_name("~/start")
            rest = f"still missing: {missing}" if missing else "all that it needs is there."
            self.get_logger().info(f"idle: call {call} (std_srvs/srv/Trigger); {rest}")

    def _start_when_ready(self, now: float) -> None:
        why = self._start()
        if not why:
            self._wanted = False
            return
        unready = bool(self._unready())
        if not unready and self._objected_since is None:
            self._objected_since = now
        objected = self._objected_since is not None and now - self._objected_since > PATIENCE_S
        if objected or (unready and self._ending_wanted and now - self._since > READY_S):
            self._wanted = False
            self._give_up(why)
        elif why != self._refusal:
            self._refusal = why
            self.get_logger().info(f"waiting: {why}")

    def _publish_state(self) -> None:
        with self._lock:
            state, reason = str(self.exciter.state), self.exciter.reason
        if self._pending_since is not None:
            state = "idle"
        reason = reason or (self._refusal if state == "idle" else "")
        progress = self._output.progress if self._output is not None else 0.0
        self._reports.publish(self.exciter.settings.joint, state, reason, progress, str(self._bag or ""))

    def _finish(self) -> None:
        """Close the bag, say how it went, and end if asked to."""
        assert self._clock_thread is not None
        error, real_time = self._clock_thread.error, self._clock_thread.real_time
        with self._lock:
            state, reason = self.exciter.state, self.exciter.reason
        if error is not None:
            state, reason = "aborted", f"commands cannot be published ({type(error).__name__}: {error})"
        recorder, self._recorder = self._recorder, None
        say = self.get_logger().info
        say(f"{self._punctuality}{', real-time priority' if real_time and self._punctuality.known else ''}")
        if recorder is not None:
            recorder.close()
            lost = recorder.lost + self._raw.lost - self._lost_before
            say(f"recorded {recorder.bag.messages} messages to {self._bag}, {lost} lost")
            if recorder.silent:
                self.get_logger().warning(f"not in the recording: {recorder.silent}")
            if recorder.bag.failure and state == "done":
                state, reason = "aborted", recorder.bag.failure
        self._clock_thread = None
        if state == "aborted" and self._ending_wanted:
            print(f"chirp_exciter: aborted: {reason}", file=sys.stderr, flush=True)
            self.status = ABORTED
        if self._ending_wanted:
            self.ending.set()

    # -- at each tick, in the thread of the clock

    def _tick(self, now: float, late: float, skipped: int) -> bool:
        """Step the rules and publish what they say; False when the run is over."""
        with self._lock:
            output = self.exciter.step(now)
        stamp = self._ros_time.at(now)
        message = self._command_messages.message(output)
        if message is not None:
            self._commands.publish(message)
        data = self._reference_messages.message(output, stamp)
        self._reference.publish(data)
        if self._recorder is not None:
            self._recorder.bag.write(self._reference.topic_name, stamp, data)
        if output.state == "exciting":
            self._punctuality.add(now, late, skipped)
        self._output = output
        return output.state in MOVING

    def _messages(self) -> CommandMessages:
        values = self._experiment.values
        joints = values[JOINTS] or [values["joint"]]
        return CommandMessages(values["command.type"], joints, values["joint"], 1.0 / values["rate_hz"])

    def end(self) -> None:
        """Ramp down what still moves and close the bag, whatever state they are in."""
        self._pending_since = None
        if self._clock_thread is not None:
            with self._lock:
                if self.exciter.state in MOVING:
                    self.exciter.stop("the node ends")
            self._clock_thread.join(RAMP_S)
            self._clock_thread.stop()
        if self._recorder is not None:
            self._recorder.close()


def main(arguments: list[str] | None = None) -> int:
    """The console script; returns the exit status: 0 done, 2 configuration, 3 refused or aborted."""

    def run(node: ChirpExciter, asked: Sequence[str]) -> int:
        sys.setswitchinterval(SWITCH_S)
        gc.collect()
        gc.freeze()  # what is there stays: collections while a robot moves are short
        executor = quick_executor()
        executor.add_node(node)
        try:
            while not node.ending.is_set():
                executor.spin_once(timeout_sec=HOUSEKEEPING_S)
                if asked:
                    node.interrupt(f"stopped by {asked[0]}")
            executor.spin_once(timeout_sec=0.0)
            time.sleep(HOUSEKEEPING_S)  # the last state leaves before the context does
        finally:
            node.end()
        return node.status

    return run_node(USAGE, ChirpExciter, run, arguments)
