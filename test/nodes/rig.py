"""Nodes as real processes over real DDS, and a watcher of the commands between them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from domains import next_domain
from rcl_interfaces.srv import SetParameters
from rclpy.client import Client
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.utilities import get_rmw_implementation_identifier
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

from flex_ident.nodes.transports import share_no_memory, without_shared_memory

JOINT = "elbow"
POSITION_LIMIT, VELOCITY_LIMIT = 0.4, 2.0
STATE_TIMEOUT_S = 1.0
"""More than the default: a test machine may pause for a third of a second, and most tests are about something else."""
QUIET_S = 0.15
"""After that time without a message, what was sent before has come."""
SIMULATED_HZ = 500.0
"""Of the virtual joint: enough for the commands, and half the load of the default on a machine of two cores."""
CHIRP = {
    "chirp.start_frequency_hz": 0.5, "chirp.end_frequency_hz": 20.0, "chirp.duration_s": 6.0, "chirp.amplitude": 0.2,
    "chirp.profile": "constant_velocity",
}  # fmt: skip
COMMANDS = "/forward_position_controller/commands"
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Rig:
    """Processes of one experiment, and a node that calls and watches them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self.state: dict[str, str] = {}
        self.states: list[str] = []
        self.commands: list[tuple[float, float]] = []
        self.references: list[tuple[float, float, float]] = []
        self.node = rclpy.create_node("rig")
        with redirect_stderr(sys.__stderr__):  # faulthandler, which it enables, wants a real file, not pytest's
            self.executor = EventsExecutor()  # a tenth of the time that rclpy.spin_once takes for each message
        self.executor.add_node(self.node)
        self.clients: dict[str, Client] = {}
        # Before the nodes are there, which find them as they come.
        self._client(Trigger, "/chirp_exciter/start")
        self._client(Trigger, "/chirp_exciter/stop")
        self._client(SetParameters, "/simulated_joint/set_parameters")
        self.node.create_subscription(DiagnosticStatus, "/chirp_exciter/state", self._on_state, LATCHED)
        self.node.create_subscription(Float64MultiArray, COMMANDS, self._on_command, 5000)
        self.node.create_subscription(JointState, "/chirp_exciter/reference", self._on_reference, 5000)

    def _on_state(self, status: DiagnosticStatus) -> None:
        self.state = {v.key: v.value for v in status.values}
        if not self.states or self.states[-1] != self.state["state"]:
            self.states.append(self.state["state"])

    def _on_command(self, message: Float64MultiArray) -> None:
        self.commands.append((time.monotonic(), message.data[-1]))

    def _on_reference(self, message: JointState) -> None:
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        self.references.append((stamp, message.position[0], message.velocity[0]))

    def start(
        self, name: str, parameters: dict[str, Any], arguments: Sequence[str] = (), *, process: str = ""
    ) -> subprocess.Popen[bytes]:
        """Start a node as a process, called as the node unless told otherwise; its output goes to NAME.log."""
        called = process or name
        command = [sys.executable, "-m", "flex_ident.nodes", name, "--ros-args", *arguments]
        for key, value in parameters.items():
            command += ["-p", f"{key}:={json.dumps(value)}"]
        with self.log(called).open("ab") as out:
            self.processes[called] = subprocess.Popen(command, stdout=out, stderr=out)
        return self.processes[called]

    def log(self, name: str) -> Path:
        """Where a node's output goes."""
        return self.folder / f"{name}.log"

    def output(self, name: str) -> str:
        """What a node has said so far."""
        return self.log(name).read_text(errors="replace")

    def simulated_joint(self, **more: Any) -> None:
        """A virtual robot with another joint beside the one that moves."""
        self.start("simulated_joint", {
            "joint": JOINT, "limits.position_min": -POSITION_LIMIT, "limits.position_max": POSITION_LIMIT,
            "limits.velocity": VELOCITY_LIMIT, "rate_hz": SIMULATED_HZ, **more,
        })  # fmt: skip

    def robot(self, name: str = "robot", **more: Any) -> None:
        """The robot of somebody else, with stand-ins for ros2_control's controllers."""
        truth = str(self._truth(name))
        given = {"limit": POSITION_LIMIT, "speed": VELOCITY_LIMIT, "truth": truth, **more}
        command = [sys.executable, str(Path(__file__).parent / "robot.py"), json.dumps(given)]
        apart = without_shared_memory(os.environ, get_rmw_implementation_identifier())  # or it pauses for 0.33 s
        with self.log(name).open("ab") as out:
            self.processes[name] = subprocess.Popen(command, stdout=out, stderr=out, env=apart)

    def _truth(self, robot: str) -> Path:
        return self.folder / ("truth" if robot == "robot" else f"{robot}_truth")

    def truth(self, joints: int = 2, *, robot: str = "robot") -> np.ndarray:
        """What the robot's joints really did: time, s, then positions, speeds and efforts, one row each instant."""
        rows = [line.split() for line in self._truth(robot).read_text().splitlines()]
        return np.array([row for row in rows if len(row) == 1 + 3 * joints], float)

    def exciter(self, arguments: Sequence[str] = (), *, process: str = "", **more: Any) -> None:
        """An exciter that waits for ~/start unless told otherwise."""
        given = {
            "joint": JOINT,
            **CHIRP,
            "limits.require_urdf": True,
            "limits.state_timeout_s": STATE_TIMEOUT_S,
            "limits.tracking_error": 0.5,  # more than the chirp's reach: each fault is seen for what it is
            "recording.directory": str(self.folder / "bags"),
            **more,
        }
        self.start("chirp_exciter", given, arguments, process=process)

    def spin(self, seconds: float) -> None:
        """Listen for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)

    def until(self, state: str, timeout_s: float = 15.0) -> bool:
        """Listen until the exciter says that it is in a state; False when it does not in time."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)
            if state in self.states:
                return True
        return False

    def node_appears(self, name: str, timeout_s: float = 20.0) -> bool:
        """Listen until a node of that name is there; False when it does not come in time."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end and name not in self.node.get_node_names():
            self.spin(0.1)
        return name in self.node.get_node_names()

    def _client(self, kind: type, service: str) -> Client:
        if service not in self.clients:
            self.clients[service] = self.node.create_client(kind, service)
        return self.clients[service]

    def ask(self, kind: type, service: str, request: Any, timeout_s: float = 15.0) -> Any:
        """The answer of a service, None when none comes in time."""
        new = service not in self.clients
        client = self._client(kind, service)
        assert client.wait_for_service(45.0), f"{service} is not there"
        if new:
            self.spin(0.3)  # Fast DDS drops the answer to a client that the server has yet to find (rmw_fastrtps 842)
        future = client.call_async(request)
        self.executor.spin_until_future_complete(future, timeout_sec=timeout_s)
        return future.result() if future.done() else None

    def call(self, service: str, timeout_s: float = 15.0) -> tuple[bool, str]:
        """Call a Trigger service: success and message."""
        answer = self.ask(Trigger, service, Trigger.Request(), timeout_s)
        assert answer is not None, f"{service} does not answer:\n" + "\n".join(map(self.output, self.processes))
        return answer.success, answer.message

    def start_exciting(self, seconds: float = 15.0, *, expected: str = "\n") -> str:
        """Call ~/start until everything is ready, or refused as expected; the last refusal, empty when it moves."""
        message = "no answer"
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            answer = self.ask(Trigger, "/chirp_exciter/start", Trigger.Request(), 3.0)
            if "moving_to_start" in self.states or (answer is not None and answer.success):
                return ""
            message = answer.message if answer is not None else message
            if expected in message:
                break
            self.spin(0.1)
        return message

    def fault(self, name: str) -> None:
        """Have the simulated joint play a fault."""
        assert self.set_parameter("simulated_joint", "fault", name) == ""

    def relay(self, origin: str) -> None:
        """Have a process hand the commands of a topic on to the simulated joint; it listens once the joint does."""
        listeners = "2"  # the rig is one
        command = [sys.executable, str(Path(__file__).parent / "relay.py"), origin, COMMANDS, listeners]
        apart = without_shared_memory(os.environ, get_rmw_implementation_identifier())
        with self.log("relay").open("ab") as out:
            self.processes["relay"] = subprocess.Popen(command, stdout=out, stderr=out, env=apart)

    def met(self, publisher: Publisher, *, seconds: float = 15.0) -> None:
        """Wait until somebody listens to a publisher."""
        end = time.monotonic() + seconds
        while publisher.get_subscription_count() == 0 and time.monotonic() < end:
            self.spin(0.1)

    def set_parameter(self, node: str, key: str, value: Any) -> str:
        """Set a parameter at run time; why that was refused, else empty."""
        message = Parameter(key, value=value).to_parameter_msg()
        request = SetParameters.Request(parameters=[message])
        for _ in range(3):  # setting it again does no harm
            answer = self.ask(SetParameters, f"/{node}/set_parameters", request, 5.0)
            if answer is not None:
                result = answer.results[0]
                return "" if result.successful else str(result.reason)
        raise AssertionError(f"{node} does not answer when {key} is set:\n{self.output(node)}")

    def ended(self, name: str, timeout_s: float = 45.0) -> int | None:
        """The exit status of a process; None when it still runs after the timeout."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end and self.processes[name].poll() is None:
            self.executor.spin_once(timeout_sec=0.05)
        self.listen_up()
        return self.processes[name].poll()

    def listen_up(self) -> None:
        """Take what was sent before and has yet to be looked at."""
        before = -1
        while before != len(self.references) + len(self.commands):
            before = len(self.references) + len(self.commands)
            self.spin(QUIET_S)

    def bag(self) -> Path:
        """The newest recording."""
        return max((self.folder / "bags").iterdir(), key=lambda p: p.stat().st_mtime)

    def largest_command(self) -> float:
        """The largest commanded position, rad."""
        return max((abs(c) for _, c in self.commands), default=0.0)

    def largest_speed(self) -> float:
        """The largest commanded speed, rad/s: as the reference says, and from one commanded position to the next."""
        said = max((abs(v) for _, _, v in self.references), default=0.0)
        steps = pairwise(self.references)
        return max(said, max((abs(b - a) / (t1 - t0) for (t0, a, _), (t1, b, _) in steps), default=0.0))

    def end(self) -> None:
        """Stop everything."""
        for process in self.processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in self.processes.values():
            try:
                process.wait(5.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.executor.shutdown()
        self.node.destroy_node()


@contextmanager
def rig(folder: Path) -> Iterator[Rig]:
    """A rig in a DDS domain of its own, on loopback."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = next_domain()
    plain = dict(os.environ)
    share_no_memory()  # and be found as soon as the nodes find each other
    rclpy.init()
    made = Rig(folder)
    os.environ.clear()
    os.environ.update(plain)
    try:
        yield made
    finally:
        made.end()
        rclpy.try_shutdown()
