"""`simulated_joint` as a process of its own over DDS: what it publishes, how it obeys, how it fails."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

rclpy = pytest.importorskip("rclpy", reason="needs rclpy")

from domains import next_domain  # noqa: E402
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue  # noqa: E402
from rcl_interfaces.srv import DescribeParameters, SetParameters  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_msgs.msg import Float64MultiArray, String  # noqa: E402
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint  # noqa: E402

from flex_ident.nodes.simulated_joint import main  # noqa: E402
from flex_ident.virtual_joint import COBOT_JOINT, SERIES_ELASTIC_JOINT  # noqa: E402

pytestmark = pytest.mark.ros
CONFIG = Path(__file__).resolve().parents[2] / "config" / "simulated_joint.yaml"
DOMAIN = next_domain()
TOPIC = "/forward_position_controller/commands"
COMMAND = [sys.executable, "-m", "flex_ident.nodes", "simulated_joint", "--ros-args"]


def environment() -> dict[str, str]:
    return {**os.environ, "ROS_DOMAIN_ID": DOMAIN, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


class Watcher:
    """A node of the test's own that hears and commands the joint."""

    def __init__(self) -> None:
        os.environ.update(environment())
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node("watcher", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.states: list[JointState] = []
        self.arrivals: list[float] = []
        self.links: list[JointState] = []
        self.descriptions: list[str] = []
        self.clients: dict[str, Any] = {}
        self.node.create_subscription(JointState, "joint_states", self._on_state, 2000)
        self.node.create_subscription(JointState, "link_joint_states", self.links.append, 2000)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(String, "/robot_description", lambda m: self.descriptions.append(m.data), latched)

    def _on_state(self, state: JointState) -> None:
        self.states.append(state)
        self.arrivals.append(time.monotonic())

    def until(self, done: Callable[[], bool], seconds: float = 20.0) -> None:
        end = time.monotonic() + seconds
        while not done():
            assert time.monotonic() < end, "nothing came"
            self.executor.spin_once(timeout_sec=0.05)

    def listen(self, seconds: float) -> list[JointState]:
        """Joint states of the next `seconds`."""
        self.states.clear()
        self.arrivals.clear()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.02)
        return list(self.states)

    def speed(self) -> float:
        """How fast the joint's time runs, by what was listened to; what had queued up before is left out."""
        arrived = np.array(self.arrivals)
        later = arrived > arrived[0] + 0.3
        return float(np.polyfit(arrived[later], stamps(self.states)[later], 1)[0])

    def call(self, kind: Any, name: str, request: Any) -> Any:
        if name not in self.clients:
            self.clients[name] = self.node.create_client(kind, name)
            assert self.clients[name].wait_for_service(10.0)
            soon = time.monotonic() + 0.3  # Fast DDS drops the answer to a client that the server has yet to find
            self.until(lambda: time.monotonic() > soon)
        future = self.clients[name].call_async(request)
        self.until(future.done)
        return future.result()

    def set(self, name: str, value: str | float) -> Any:
        content = (
            ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=value)
            if isinstance(value, str)
            else ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
        )
        request = SetParameters.Request(parameters=[Parameter(name=name, value=content)])
        return self.call(SetParameters, "/simulated_joint/set_parameters", request).results[0]

    def publisher(self, kind: Any, topic: str) -> Any:
        publisher = self.node.create_publisher(kind, topic, 10)
        self.until(lambda: publisher.get_subscription_count() > 0)
        return publisher


@pytest.fixture
def watcher() -> Iterator[Watcher]:
    watcher = Watcher()
    yield watcher
    watcher.executor.shutdown()
    watcher.node.destroy_node()
    rclpy.shutdown(context=watcher.context)


@pytest.fixture
def start(watcher: Watcher, tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """A function that starts the node with parameters and waits for its joint states."""
    running: list[subprocess.Popen[str]] = []

    def started(**parameters: Any) -> subprocess.Popen[str]:
        file = tmp_path / "parameters.yaml"
        file.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
        process = subprocess.Popen(
            [*COMMAND, "--params-file", str(file)], env=environment(), text=True, stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
        )  # fmt: skip
        running.append(process)
        watcher.until(lambda: len(watcher.states) > 0 and len(watcher.descriptions) > 0, 40.0)
        return process

    yield started
    for process in running:
        process.kill()
        process.wait()


def stamps(states: list[JointState]) -> np.ndarray:
    return np.array([s.header.stamp.sec + 1e-9 * s.header.stamp.nanosec for s in states])


def test_states_at_1_khz_commands_and_the_description(watcher: Watcher, start: Any) -> None:
    process = start(other_joints=["shoulder"], start_position=0.3, **{"limits.effort": 150.0})
    states = watcher.listen(3.0)
    assert list(states[-1].name) == ["joint_1", "shoulder"]
    steps = np.diff(stamps(states))
    assert watcher.speed() == pytest.approx(1.0, rel=0.1)
    assert np.max(np.abs(steps - 1e-3)) < 1e-6
    assert states[-1].position[0] == pytest.approx(0.3, abs=1e-4)
    torque = np.mean([s.effort[0] for s in states])
    assert torque == pytest.approx(9.81 * (0.5 * np.cos(0.3) + 3.0 * np.sin(0.3)), abs=0.1)
    link = watcher.links[-1]
    assert list(link.name) == ["joint_1"]
    assert states[-1].position[0] - link.position[0] == pytest.approx(torque / 1e4, abs=3e-5)
    assert '<joint name="shoulder"' in watcher.descriptions[0]
    assert 'effort="150.0"' in watcher.descriptions[0]
    commands = watcher.publisher(Float64MultiArray, TOPIC)
    for wrong in ([0.5], [float("nan"), 0.0], [0.5, 0.0, 0.0]):
        commands.publish(Float64MultiArray(data=wrong))
    assert watcher.listen(0.5)[-1].position[0] == pytest.approx(0.3, abs=1e-3)
    commands.publish(Float64MultiArray(data=[0.35, 0.0]))
    assert watcher.listen(1.5)[-1].position[0] == pytest.approx(0.35, abs=2e-3)
    process.send_signal(signal.SIGINT)
    status = process.wait(10.0)
    assert process.stderr is not None
    said = process.stderr.read()
    assert status == 0, said
    assert "Traceback" not in said


def test_trajectories_and_time_that_runs_faster(watcher: Watcher, start: Any) -> None:
    start(speed=2.0, rate_hz=500.0, **{"controller.type": "joint_trajectory", "controller.topic": "/arm/trajectory"})
    commands = watcher.publisher(JointTrajectory, "/arm/trajectory")
    points = [JointTrajectoryPoint(positions=[p, 0.0]) for p in (0.2, 0.1)]
    points[0].time_from_start.sec, points[1].time_from_start.sec = 1, 3
    commands.publish(JointTrajectory(joint_names=["joint_1", "other"], points=points))
    states = watcher.listen(2.5)
    assert watcher.speed() == pytest.approx(2.0, rel=0.1)
    position = np.array([s.position[0] for s in states])
    top = int(np.argmax(position))
    assert position[top] == pytest.approx(0.2, abs=0.01)
    falling = position[top + 200 : top + 700]
    assert np.mean(np.diff(falling)) * 500.0 == pytest.approx(-0.05, rel=0.05)
    assert position[-1] == pytest.approx(0.1, abs=0.005)


@pytest.mark.parametrize(
    ("interface", "command"), [("velocity", 0.2), pytest.param("effort", 6.0, marks=pytest.mark.campaign)]
)
def test_velocity_and_effort_commands(watcher: Watcher, start: Any, interface: str, command: float) -> None:
    start(MX=0.0, MY=0.0, FVm=20.0, FSm=1.0, FS=0.5, FV=0.0, **{"controller.interface": interface})
    assert abs(watcher.listen(0.3)[-1].velocity[0]) < 1e-3
    watcher.publisher(Float64MultiArray, TOPIC).publish(Float64MultiArray(data=[command]))
    expected = 0.2 if interface == "velocity" else (6.0 - 1.5) / 20.0
    latest = watcher.listen(1.5)[-100:]  # a listener that was held up has old ones in front of them
    assert np.mean([s.velocity[0] for s in latest]) == pytest.approx(expected, rel=0.02)


def test_a_model_file_its_effects_and_what_is_described(watcher: Watcher, start: Any, tmp_path: Path) -> None:
    file = tmp_path / "model.yaml"
    SERIES_ELASTIC_JOINT.with_effect("torque_offset", {"offset": 0.7}).write(file)
    start(model_file=str(file), MY=0.5, start_position=0.5, link_encoder=False)
    states = watcher.listen(1.0)
    expected = 9.81 * (0.02 * np.cos(0.5) + 0.5 * np.sin(0.5)) + 0.7
    assert np.mean([s.effort[0] for s in states]) == pytest.approx(expected, abs=0.1)
    assert not watcher.links
    request = DescribeParameters.Request(names=["K", "effects.backlash.gap", "fault"])
    described = watcher.call(DescribeParameters, "/simulated_joint/describe_parameters", request).descriptors
    assert "N m/rad" in described[0].description
    assert described[0].floating_point_range[0].from_value == 0.0
    assert described[0].read_only
    assert "rad" in described[1].description
    assert "lose_joint" in described[2].additional_constraints
    assert not watcher.set("K", 1.0).successful
    refusal = watcher.set("fault", "fire")
    assert not refusal.successful
    assert "one of none, stop" in refusal.reason


def test_faults(watcher: Watcher, start: Any) -> None:
    start(other_joints=["shoulder"], rate_hz=500.0)
    moving = watcher.publisher(Float64MultiArray, TOPIC)
    before = stamps(watcher.listen(0.2))[-1]

    def seen(fault: str) -> list[JointState]:
        assert watcher.set("fault", fault).successful
        watcher.listen(0.2)
        moving.publish(Float64MultiArray(data=[0.1 if watcher.states[-1:] and fault == "none" else 0.2, 0.0]))
        return watcher.listen(0.4)

    assert not seen("stop")
    frozen = seen("freeze")
    assert len({(s.position[0], s.effort[0]) for s in frozen}) == 1
    assert np.all(np.diff(stamps(frozen)) > 0)
    assert all(np.isnan(s.position[0]) for s in seen("nan"))
    assert stamps(seen("time_jump"))[0] - before > 5.0
    assert all(list(s.name) == ["shoulder"] and len(s.position) == 1 for s in seen("lose_joint"))
    healthy = seen("none")
    assert list(healthy[-1].name) == ["joint_1", "shoulder"]
    assert np.isfinite(healthy[-1].position[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-p", "rate_hz:=-5.0"], "rate_hz is -5.0: expected a number from 10 to 10000"),
        (["-p", "rate_hz:=fast"], "rate_hz is 'fast': expected a number"),
        (["-p", "Kk:=3.0"], "unknown parameter 'Kk': did you mean 'K'?"),
        (["-p", "Jm:=0.0"], "Jm of the virtual joint is 0.0: it must be positive"),
        (["-p", "controller.type:=servo"], "expected one of forward_command, joint_trajectory"),
        (["-p", "model_file:=/nowhere.yaml"], "/nowhere.yaml: cannot be read"),
        (["-p", "effects.backlash.gap:=-1.0"], "effects.backlash.gap is -1.0"),
        (["-p", "effects.stribeck_friction.amplitude:=3.0"], "effects.stribeck_friction needs velocity"),
        (["-p", "J:=2.0", "-p", "K:=3.0"], "unknown parameter 'K'"),
        (["-p", "joint:=a", "-p", "other_joints:=[a]"], "must be names that differ"),
        (["-p", "controller.joints:=[b]"], "does not hold the joint 'joint_1'"),
        (["-p", "limits.position_min:=4.0"], "is not below limits.position_max"),
        (["-p", "controller.type:=joint_trajectory", "-p", "controller.interface:=effort"], "interface position"),
    ],
)  # fmt: skip
def test_bad_parameters_are_refused_by_name(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", DOMAIN)
    assert main(["--ros-args", *arguments]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert len(said.strip().splitlines()) == 1


def test_a_refusal_is_one_line_and_status_2_of_the_process() -> None:
    done = subprocess.run([*COMMAND, "-p", "Kk:=3.0"], env=environment(), capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert done.stderr == "simulated_joint: unknown parameter 'Kk': did you mean 'K'?\n"


def test_the_shipped_configuration_starts_the_default_joint(watcher: Watcher) -> None:
    content = yaml.safe_load(CONFIG.read_text())["/**"]["ros__parameters"]
    for key, value in COBOT_JOINT.parameters.items():
        assert content[key] == value
    process = subprocess.Popen([*COMMAND, "--params-file", str(CONFIG)], env=environment(), stderr=subprocess.DEVNULL)
    try:
        watcher.until(lambda: len(watcher.states) > 100, 40.0)
    finally:
        process.send_signal(signal.SIGTERM)
        assert process.wait(10.0) == 0
