"""The demo, live: virtual joint, exciter and identifier as processes of their own, asked from this one by service."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from rcl_interfaces.srv import SetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Trigger

from flex_ident.commands.truth import HEADER, truth_rows_text
from flex_ident.errors import DataError
from flex_ident.report.table import text_table
from flex_ident.virtual_joint import COBOT_JOINT

JOINT = "joint_1"
CHIRP = {
    "chirp.profile": "constant_velocity", "chirp.start_frequency_hz": 0.5, "chirp.end_frequency_hz": 30.0,
    "chirp.amplitude": 0.2, "chirp.duration_s": 40.0, "rate_hz": 1000.0, "limits.velocity": 2.5,
    "limits.state_timeout_s": 1.0, "limits.tracking_error": 0.5,
}  # fmt: skip
"""The last two are wide: a computer that pauses can break nothing here."""
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
WAIT_S = 20.0
Say = Callable[[str], None]


@contextmanager
def processes(log: Path) -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """A function that starts a node as a process; all that still run are stopped at the end."""
    running: list[subprocess.Popen[bytes]] = []
    with log.open("wb") as out:

        def start(name: str, parameters: dict[str, Any]) -> subprocess.Popen[bytes]:
            arguments = [sys.executable, "-m", "flex_ident.nodes", name, "--ros-args"]
            for key, value in parameters.items():
                arguments += ["-p", f"{key}:={json.dumps(value)}"]
            running.append(subprocess.Popen(arguments, stdout=out, stderr=out, start_new_session=True))
            return running[-1]

        try:
            yield start
        finally:
            for process in running:
                if process.poll() is None:
                    process.send_signal(signal.SIGINT)
            for process in running:
                try:
                    process.wait(5.0)
                except subprocess.TimeoutExpired:
                    process.kill()


def live_run(folder: Path, *, seed: int, say: Say) -> int:
    """Excite, record, identify, report; prints truth beside estimate. Raises DataError when a node fails."""
    folder.mkdir(parents=True, exist_ok=True)
    folder = folder.resolve()
    started = time.monotonic()
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    log = folder / "nodes.log"
    with processes(log) as start:
        say("1/4  starting a virtual joint (two masses, a spring, friction, gravity) and the identifier, over DDS")
        start("simulated_joint", {"joint": JOINT, "seed": float(seed)})
        start("identifier", {
            "bag_directories": [str(folder)], "output_directory": str(folder / "results"), "joint": JOINT,
        })  # fmt: skip
        rclpy.init()
        node = rclpy.create_node("flex_ident_demo")
        # Both are found while the joint moves: Fast DDS drops the answer to a client that the server has yet to find.
        setter = node.create_client(SetParameters, "/identifier/set_parameters")
        client = node.create_client(Trigger, "/identifier/identify")
        try:
            say(f"2/4  {JOINT} follows a chirp, 0.5 to 30 Hz in {CHIRP['chirp.duration_s']:.0f} s, and is recorded")
            exciter = start("chirp_exciter", {
                **CHIRP, "joint": JOINT, "auto_start": True, "recording.directory": str(folder / "recordings"),
            })  # fmt: skip
            bag = _excited(node, exciter, log, say)
            say(f"     recorded: {bag}")
            say("3/4  asking /identifier/identify, a std_srvs/Trigger")
            content = _identified(node, setter, client, bag)
        finally:
            node.destroy_node()
            rclpy.try_shutdown()
    report = folder / "results" / f"{bag.stem}_{JOINT}" / "report.html"
    say(f"4/4  verdict: {content['verdict']}, done in {time.monotonic() - started:.0f} s\n")
    print(text_table(HEADER, truth_rows_text(content, COBOT_JOINT), right=(1, 2, 3)))
    print(f"\nreport: {report}")
    return 0


def _excited(node: Node, exciter: subprocess.Popen[bytes], log: Path, say: Say) -> Path:
    """The bag that the exciter leaves; its progress is shown meanwhile."""
    latest: dict[str, str] = {}

    def received(status: DiagnosticStatus) -> None:
        latest.update({v.key: v.value for v in status.values})

    node.create_subscription(DiagnosticStatus, "/chirp_exciter/state", received, LATCHED)
    shown = -1
    bag = ""
    while exciter.poll() is None:
        rclpy.spin_once(node, timeout_sec=0.2)
        bag = latest.get("bag") or bag
        percent = int(latest.get("progress_percent", "0"))
        if percent // 10 > shown // 10 or shown < 0:
            shown = percent
            say(f"     {latest.get('state', 'starting').replace('_', ' ')}, {percent} %")
    if exciter.returncode != 0 or not bag:
        last = log.read_text(errors="replace").strip().splitlines()[-1:]
        raise DataError(f"the chirp was not played: {' '.join(last) or 'see ' + str(log)}")
    return Path(bag)


def _identified(node: Node, setter: Client, client: Client, bag: Path) -> dict[str, Any]:
    """What the identifier's service answers for the bag."""
    if not (setter.wait_for_service(WAIT_S) and client.wait_for_service(WAIT_S)):
        raise DataError("the identifier does not answer.")
    value = Parameter("bag", Parameter.Type.STRING, str(bag)).to_parameter_msg()
    done = setter.call_async(SetParameters.Request(parameters=[value]))
    rclpy.spin_until_future_complete(node, done, timeout_sec=WAIT_S)
    if not done.done():
        raise DataError("the identifier does not answer.")
    answer = client.call_async(Trigger.Request())
    rclpy.spin_until_future_complete(node, answer, timeout_sec=120.0)
    response = answer.result()
    if response is None or not response.message.startswith("{"):
        raise DataError(f"identification failed: {response.message if response else 'no answer in 120 s'}")
    content: dict[str, Any] = json.loads(response.message)
    return content
