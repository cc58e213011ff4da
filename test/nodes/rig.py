"""Nodes as real processes over real DDS, and a watcher of the commands between them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

JOINT = "elbow"
POSITION_LIMIT, VELOCITY_LIMIT = 0.4, 2.0
CHIRP = {
    "chirp.start_frequency_hz": 0.5, "chirp.end_frequency_hz": 20.0, "chirp.duration_s": 8.0, "chirp.amplitude": 0.2,
    "chirp.profile": "constant_velocity",
}  # fmt: skip
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Rig:
    """Processes of one experiment, and a node that calls and watches them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self.state: dict[str, str] = {}
        self.states: list[str] = []
        self.commands: list[tuple[float, float]] = []
        self.node = rclpy.create_node("rig")
        self.node.create_subscription(DiagnosticStatus, "/chirp_exciter/state", self._on_state, LATCHED)
        self.node.create_subscription(
            Float64MultiArray, "/forward_position_controller/commands", self._on_command, 1000
        )

    def _on_state(self, status: DiagnosticStatus) -> None:
        self.state = {v.key: v.value for v in status.values}
        if not self.states or self.states[-1] != self.state["state"]:
            self.states.append(self.state["state"])

    def _on_command(self, message: Float64MultiArray) -> None:
        self.commands.append((time.monotonic(), message.data[-1]))

    def start(self, name: str, parameters: dict[str, Any], **environment: str) -> subprocess.Popen[bytes]:
        """Start a node as a process; its output goes to NAME.log."""
        arguments = [sys.executable, "-m", f"flex_ident.nodes.{name}", "--ros-args"]
        for key, value in parameters.items():
            arguments += ["-p", f"{key}:={json.dumps(value)}"]
        with self.log(name).open("ab") as out:
            process = subprocess.Popen(arguments, stdout=out, stderr=out, env={**os.environ, **environment})
        self.processes[name] = process
        return process

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
            "limits.velocity": VELOCITY_LIMIT, **more,
        })  # fmt: skip

    def exciter(self, *, environment: dict[str, str] | None = None, **more: Any) -> None:
        """An exciter that waits for ~/start unless told otherwise."""
        given = {
            "joint": JOINT,
            **CHIRP,
            "limits.require_urdf": True,
            "recording.directory": str(self.folder / "bags"),
            **more,
        }
        self.start("chirp_exciter", given, **(environment or {}))

    def spin(self, seconds: float) -> None:
        """Listen for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def until(self, state: str, timeout_s: float = 15.0) -> bool:
        """Listen until the exciter says that it is in a state; False when it does not in time."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)
            if state in self.states:
                return True
        return False

    def call(self, service: str, timeout_s: float = 15.0) -> tuple[bool, str]:
        """Call a Trigger service: success and message."""
        client = self.node.create_client(Trigger, service)
        assert client.wait_for_service(timeout_s), service
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=timeout_s)
        answer = future.result()
        assert answer is not None, f"{service} does not answer"
        return answer.success, answer.message

    def start_exciting(self) -> str:
        """Call ~/start until everything is ready; the last refusal, empty when it moves."""
        message = ""
        for _ in range(40):
            success, message = self.call("/chirp_exciter/start")
            if success:
                return ""
            self.spin(0.25)
        return message

    def fault(self, name: str) -> None:
        """Have the simulated joint play a fault."""
        client = self.node.create_client(SetParameters, "/simulated_joint/set_parameters")
        assert client.wait_for_service(5.0)
        value = Parameter("fault", Parameter.Type.STRING, name).to_parameter_msg()
        future = client.call_async(SetParameters.Request(parameters=[value]))
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=5.0)

    def ended(self, name: str, timeout_s: float = 15.0) -> int | None:
        """The exit status of a process; None when it still runs after the timeout."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end and self.processes[name].poll() is None:
            rclpy.spin_once(self.node, timeout_sec=0.05)
        return self.processes[name].poll()

    def bag(self) -> Path:
        """The newest recording."""
        return max((self.folder / "bags").iterdir(), key=lambda p: p.stat().st_mtime)

    def largest_command(self) -> float:
        """The largest commanded position, rad."""
        return max((abs(c) for _, c in self.commands), default=0.0)

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
        self.node.destroy_node()


@contextmanager
def rig(folder: Path) -> Iterator[Rig]:
    """A rig in a DDS domain of its own, on loopback."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = str(1 + (os.getpid() + int(time.monotonic())) % 100)
    rclpy.init()
    made = Rig(folder)
    try:
        yield made
    finally:
        made.end()
        rclpy.try_shutdown()
