"""Node `identifier`: answers service calls with identified parameters."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from diagnostic_msgs.srv import SelfTest
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from flex_ident.commands.common import one_line
from flex_ident.configuration.settings import GAP_SETTINGS, IDENTIFY_SETTINGS, SET_SETTINGS, Setting
from flex_ident.errors import ConfigurationError, FlexIdentError
from flex_ident.jobs.explaining import finished_explanation
from flex_ident.jobs.explaining_set import finished_gap_set
from flex_ident.jobs.identifying import finished_identification
from flex_ident.jobs.options import gap_options, identify_options
from flex_ident.jobs.places import Place
from flex_ident.jobs.sets import refuse_of_one, set_name, texts_of
from flex_ident.jobs.several import finished_set
from flex_ident.jobs.signals import signal_selection
from flex_ident.likelihood.cores import WorkStoppedError, stop_if_asked, stopped_when
from flex_ident.nodes.allowed_paths import allowed_path
from flex_ident.nodes.declared import current, declare, refuse_unknown
from flex_ident.nodes.health import LEVELS, failed, health_of
from flex_ident.nodes.job import IDLE, Job
from flex_ident.nodes.running import run_node, spin
from flex_ident.nodes.usage import Usage
from flex_ident.recording.names import at_home

COMMANDS_ONLY = ("out",)
"""Keys of the commands that a file for both may hold."""
SETTINGS = tuple(s for s in IDENTIFY_SETTINGS if s.key not in (*COMMANDS_ONLY, "model", "urdf"))
NODE_SETTINGS = (
    Setting(
        "bag", "", "the recording: a path inside bag_directories; several, as a list or with ';' between them, are one "
        "joint recorded several times", many=True, separator=";",
    ),
    Setting("model", "", "a model.yaml to start from, inside bag_directories"),
    Setting("urdf", "", "the robot's URDF, inside bag_directories: which way gravity pulls on this joint, and whether "
            "the effort holds it"),
    Setting("baseline", "", "a result.json or gap.json of the joint, or its folder, inside bag_directories: what "
            "~/health compares with"),
    *GAP_SETTINGS,
    *SET_SETTINGS,
)  # fmt: skip
FIXED_SETTINGS = (
    Setting("output_directory", "flex_ident_results", "where results are written; empty: nowhere"),
    Setting("health", False, "publish ~/health (latched diagnostics) with each result"),
)
DIRECTORIES = "bag_directories"
DIRECTORIES_TEXT = "folders that bags may lie in; nothing outside is read"
USAGE = Usage(
    "identifier",
    "Answers calls of ~/identify, ~/explain_gap (std_srvs/Trigger) and ~/self_test (diagnostic_msgs/SelfTest) with the "
    "parameters of the joint in a recording; ~/cancel stops what runs, ~/state says how far it is. Set 'bag' first, "
    "here or at run time.",
    (*NODE_SETTINGS, *SETTINGS, *FIXED_SETTINGS),
    {DIRECTORIES: f"{DIRECTORIES_TEXT} [['.']]"},
)
ANSWER_S = 5.0
"""How long a job that is stopped may take to answer before rclpy goes."""
SENT_S = 0.1
"""How long an answer takes to leave: rclpy sends it after the job has ended, and does not say when."""
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
Content = dict[str, Any]


class Identifier(Node):
    """One job at a time, in the thread of the call that asked for it; other calls are answered meanwhile."""

    def __init__(self) -> None:
        super().__init__("identifier")
        declare(self, SETTINGS)
        declare(self, NODE_SETTINGS)
        declare(self, FIXED_SETTINGS, read_only=True)
        folders = ParameterDescriptor(description=DIRECTORIES_TEXT, read_only=True)
        self.declare_parameter(DIRECTORIES, ["."], folders)
        refuse_unknown(self, COMMANDS_ONLY)
        self._check()
        self.add_on_set_parameters_callback(self._checked)
        self._state = self.create_publisher(DiagnosticStatus, "~/state", LATCHED)
        self._said = ""
        self.job = Job(self._publish_state)
        group = ReentrantCallbackGroup()
        self.create_service(Trigger, "~/identify", self._identify, callback_group=group)
        self.create_service(Trigger, "~/explain_gap", self._explain_gap, callback_group=group)
        self.create_service(Trigger, "~/cancel", self._cancel, callback_group=group)
        self.create_service(SelfTest, "~/self_test", self._self_test, callback_group=group)
        self._result = self.create_publisher(String, "~/result", LATCHED)
        asked = bool(self.get_parameter("health").value)
        self._health = self.create_publisher(DiagnosticArray, "~/health", LATCHED) if asked else None
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_timer(1.0, self._diagnose, callback_group=group)
        self._publish_state()

    def _check(self, changes: Iterable[Parameter] = ()) -> None:
        """Refuse what a call would refuse before it reads anything. Raises UsageError and ConfigurationError.

        Files, the model among them, are looked at when a call needs them: they may come later.
        """
        known = {s.key: s for s in (*SETTINGS, *NODE_SETTINGS)}
        changed = {p.name: known[p.name].checked(p.value, self.get_name()) for p in changes if p.name in known}
        values = {**current(self, known.values()), **changed, "model": ""}
        signal_selection(values)
        identify_options(values)
        gap_options(values)

    def _checked(self, parameters: list[Parameter]) -> SetParametersResult:
        try:
            self._check(parameters)
        except FlexIdentError as error:
            return SetParametersResult(successful=False, reason=one_line(error))
        return SetParametersResult(successful=True)

    def _identify(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._answer(response, "identify", self._identified)

    def _explain_gap(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._answer(response, "explain_gap", self._explained)

    def _cancel(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        name = self.job.name
        response.success = self.job.stop("cancelled by ~/cancel")
        response.message = f"stopping {name}: its caller is answered." if response.success else "nothing to cancel."
        return response

    def _self_test(self, _request: SelfTest.Request, response: SelfTest.Response) -> SelfTest.Response:
        content, said = self._content_or_reason("self_test", self._identified)
        response.id = self.get_name()
        if content is None:
            response.passed = b"\x00"
            response.status = [DiagnosticStatus(level=DiagnosticStatus.ERROR, name="identify", message=said)]
            return response
        response.id = f"{content['joint']}"
        response.passed = b"\x00" if content["verdict"] == "rejected" else b"\x01"
        level = LEVELS[content["verdict"]]
        response.status = [
            DiagnosticStatus(
                level=level if p["identifiable"] else DiagnosticStatus.WARN if level == DiagnosticStatus.OK else level,
                name=key, message=content["verdict"] if p["identifiable"] else "not identifiable",
                hardware_id=content["joint"],
                values=[KeyValue(key=k, value=json.dumps(v).strip('"')) for k, v in p.items()],
            )
            for key, p in content["parameters"].items()
        ]  # fmt: skip
        return response

    def _answer(self, response: Trigger.Response, name: str, job: Callable[[], Content]) -> Trigger.Response:
        content, said = self._content_or_reason(name, job)
        response.success = content is not None and content["verdict"] != "rejected"
        response.message = said if content is None else json.dumps(content, allow_nan=False)
        return response

    def _content_or_reason(self, name: str, job: Callable[[], Content]) -> tuple[Content | None, str]:
        """The job's JSON content, or None and one line that says why not."""
        if not self.job.begin(name, len(texts_of(self.get_parameter("bag").value))):
            return None, f"busy with {self.job.name}, {self.job.percent} % done: call again when it is finished."
        why = ""
        try:
            with stopped_when(self.job.stopping):
                content = job()
            self._result.publish(String(data=json.dumps(content, allow_nan=False)))
            self._tell_health(lambda: health_of(content, self.get_name(), self._baseline))
            verdict = str(content["verdict"])
            self.get_logger().info(f"{name}: {content['joint']}: {verdict}")
            self.job.end(verdict)
            return content, ""
        except WorkStoppedError:
            why = f"stopped: {self.job.why_stopped}."
            self.get_logger().warning(f"{name}: {why}")
        except FlexIdentError as error:
            why = one_line(error)
            self.get_logger().error(f"{name}: {why}")
            self._tell_health(lambda: failed(self.get_name(), f"{name}: {why}"))
        except Exception as error:  # a service must answer
            why = (
                f"stopped: {self.job.why_stopped}."
                if self.job.stopping()
                else f"internal error ({type(error).__name__}: {one_line(error)}): please report it."
            )
            self.get_logger().error(f"{name}: {why}")
        self.job.end(why, failed=True)
        return None, why

    def _baseline(self) -> Path | None:
        """What the latest result is compared with. Raises UsageError for a path outside the folders allowed."""
        text = str(self.get_parameter("baseline").value)
        return allowed_path(text, list(self.get_parameter(DIRECTORIES).value), what="baseline") if text else None

    def _tell_health(self, status: Callable[[], DiagnosticStatus]) -> None:
        """Publish the latest result's health, where that is asked for."""
        if self._health is None:
            return
        array = DiagnosticArray(status=[status()])
        array.header.stamp = self.get_clock().now().to_msg()
        self._health.publish(array)

    def _progress(self, text: str, share: float) -> None:
        stop_if_asked()
        self.job.told(text, share)

    def _values(self) -> dict[str, Any]:
        values: dict[str, Any] = {**current(self, SETTINGS), **current(self, NODE_SETTINGS), "out": ""}
        folders = list(self.get_parameter(DIRECTORIES).value)
        bags = texts_of(values["bag"]) or [""]
        values["bags"] = [allowed_path(text, folders, what="bag") for text in bags]
        values["bag"] = str(values["bags"][0])
        for key in ("model", "urdf", "simulated"):
            if values[key]:
                values[key] = str(allowed_path(str(values[key]), folders, what=key))
        if values["joint"] == "all":
            raise ConfigurationError("joint is 'all': a service call identifies one joint.")
        return values

    def _folder(self, bag: str, joint: str) -> Path | None:
        base = str(self.get_parameter("output_directory").value)
        return at_home(base) / f"{Path(bag).stem}_{joint.replace('/', '_')}" if base else None

    def _identified(self) -> Content:
        values = self._values()
        bags = values["bags"]
        if len(bags) > 1:
            name = set_name(bags)
            place = Place(lambda joint: self._folder(name, joint), shared=False)
            return finished_set(bags, values, place, progress=self._progress).content
        refuse_of_one(values)
        done = finished_identification(
            Path(values["bag"]), values, lambda joint: self._folder(values["bag"], joint), progress=self._progress
        )
        return done.content

    def _explained(self) -> Content:
        values = self._values()
        bags = values["bags"]
        if len(bags) > 1:
            name = set_name(bags)
            place = Place(lambda joint: self._folder(name, joint), shared=False)
            return finished_gap_set(bags, values, place, progress=self._progress).content
        refuse_of_one(values)
        done = finished_explanation(
            Path(values["bag"]), values, lambda joint: self._folder(values["bag"], joint), progress=self._progress
        )
        return done.content

    def _status(self) -> DiagnosticStatus:
        """What the node does, or how its latest job ended."""
        job = self.job
        text = f"{job.name}, {job.percent} %" if job.name != IDLE else IDLE
        if job.ended:
            text += f", latest: {job.ended}"
        level = LEVELS.get(job.ended, DiagnosticStatus.OK)
        if job.failed:
            level = DiagnosticStatus.WARN if job.stopped else DiagnosticStatus.ERROR
        name = self.get_fully_qualified_name().lstrip("/")
        values = {"state": job.name, "progress_percent": f"{job.percent}", "latest": job.ended}
        return DiagnosticStatus(
            level=level, name=f"{name}: identification", message=text, hardware_id=name,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )  # fmt: skip

    def _publish_state(self) -> None:
        """Say the state where it has changed."""
        status = self._status()
        if status.message != self._said:
            self._said = status.message
            self._state.publish(status)

    def _diagnose(self) -> None:
        array = DiagnosticArray(status=[self._status()])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)


def main(arguments: list[str] | None = None) -> int:
    """The console script; returns the exit status."""

    def run(node: Identifier, asked: Sequence[str]) -> int:
        executor = MultiThreadedExecutor(num_threads=4)
        executor.add_node(node)
        node.get_logger().info("ready: set the parameter 'bag' and call ~/identify")
        spin(executor, asked)
        node.job.stop("the node ends")
        ends = time.monotonic() + ANSWER_S
        while node.job.busy and time.monotonic() < ends:
            executor.spin_once(timeout_sec=0.05)
        time.sleep(SENT_S)
        executor.shutdown(0.0)
        return 0

    return run_node(USAGE, Identifier, run, arguments)
