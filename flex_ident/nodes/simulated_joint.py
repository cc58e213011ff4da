"""Node `simulated_joint`: a virtual robot joint that takes the commands and publishes the topics of a robot."""

from __future__ import annotations

import math
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory

from flex_ident.configuration.settings import Setting, Value
from flex_ident.effects import check_effect_parameters
from flex_ident.effects.catalogue import CATALOGUE
from flex_ident.errors import ConfigurationError
from flex_ident.nodes.declared import current, declare
from flex_ident.nodes.running import run_node
from flex_ident.nodes.trajectory import TrajectoryCommand
from flex_ident.parameters import FLEXIBLE_KEYS, RIGID_KEYS, JointModel, read_joint_model
from flex_ident.virtual_joint import COBOT_JOINT, Instruments, Interface, VirtualJoint, drive_for

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
FAULTS = ("none", "stop", "freeze", "nan", "time_jump", "lose_joint")
SETTINGS = (
    Setting("joint", "joint_1", "name of the joint that moves"),
    Setting("model_file", "", "a model.yaml; without it each parameter by its key, default a cobot's joint"),
    Setting("rate_hz", 1000.0, "rate of control and of the published states", lower=10.0, upper=10000.0),
    Setting("speed", 1.0, "faster than real time by this factor", lower=0.01, upper=100.0),
    Setting("seed", 0.0, "seed of the noise", lower=0.0, upper=2.0**31),
    Setting("link_encoder", True, "publish link_joint_states"),
    Setting("start_position", 0.0, "motor position at the start, rad", lower=-100.0, upper=100.0),
    Setting("controller.type", "forward_command", "how commands come", choices=("forward_command", "joint_trajectory")),
    Setting("controller.interface", "position", "what is commanded", choices=("position", "velocity", "effort")),
    Setting(
        "controller.smoothing_hz", 25.0, "position commands are smoothed at this frequency", lower=1.0, upper=1000.0
    ),
    Setting("controller.topic", "/forward_position_controller/commands", "where commands come from"),
    Setting("noise.motor_bits", 20.0, "bits a turn of the motor encoder", lower=8.0, upper=32.0),
    Setting("noise.link_bits", 20.0, "bits a turn of the link encoder", lower=8.0, upper=32.0),
    Setting("noise.torque", 0.2, "standard deviation of the torque's noise, N m", lower=0.0, upper=1e6),
    Setting("limits.position_min", -3.1, "lower limit in /robot_description, rad", lower=-1e3, upper=1e3),
    Setting("limits.position_max", 3.1, "upper limit in /robot_description, rad", lower=-1e3, upper=1e3),
    Setting("limits.velocity", 3.0, "speed limit in /robot_description, rad/s", lower=1e-3, upper=1e3),
    Setting("limits.effort", 300.0, "effort limit of the drive, N m", lower=1e-3, upper=1e7),
    Setting("fault", "none", "a fault to play, for tests", choices=FAULTS),
)


class SimulatedJoint(Node):
    """Steps the virtual joint in its own thread by a steady clock; a late tick catches up, so that data stay exact."""

    def __init__(self) -> None:
        super().__init__("simulated_joint", automatically_declare_parameters_from_overrides=False)
        declare(self, SETTINGS)
        self.declare_parameter("other_joints", Parameter.Type.STRING_ARRAY)
        values = current(self, SETTINGS)
        self._values = values
        self.model = self._model(values)
        self.names = [str(values["joint"]), *self._strings("other_joints")]
        self._interface: Interface = str(values["controller.interface"])  # type: ignore[assignment]
        drive = replace(
            drive_for(self.model, effort_limit=float(values["limits.effort"]), interface=self._interface),
            inertia=0.0,
            smoothing_hz=float(values["controller.smoothing_hz"]),
        )
        instruments = Instruments(
            2.0 * math.pi / 2.0 ** float(values["noise.motor_bits"]),
            2.0 * math.pi / 2.0 ** float(values["noise.link_bits"]),
            float(values["noise.torque"]),
        )
        start = float(values["start_position"])
        rate = float(values["rate_hz"])
        self._joint = VirtualJoint(
            self.model, rate_hz=rate, drive=drive, instruments=instruments, seed=int(float(values["seed"])), start=start
        )
        self._command = start if self._interface == "position" else 0.0
        if self._interface == "effort":
            self._command = self._joint.step(0.0).motor_torque
        self._trajectory: TrajectoryCommand | None = None
        self._states = self.create_publisher(JointState, "joint_states", 1000)
        self._links = None
        if values["link_encoder"] and not self.model.rigid:
            self._links = self.create_publisher(JointState, "link_joint_states", 1000)
        self._description = self.create_publisher(String, "/robot_description", LATCHED)
        self._description.publish(String(data=self._urdf(values)))
        topic = str(values["controller.topic"])
        if values["controller.type"] == "forward_command":
            self.create_subscription(Float64MultiArray, topic, self._on_forward, 100)
        else:
            self.create_subscription(JointTrajectory, topic, self._on_trajectory, 100)
        self._fault = str(values["fault"])
        self.add_post_set_parameters_callback(self._on_parameters)
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def begin(self) -> None:
        """Let time pass."""
        self._thread.start()
        self.get_logger().info(
            f"{self.names[0]}: a virtual joint at {self._values['rate_hz']:.0f} Hz, commands on "
            f"{self._values['controller.topic']} ({self._interface})"
        )

    def end(self) -> None:
        """Stop the clock."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(1.0)

    def _strings(self, name: str) -> list[str]:
        value = self.get_parameter_or(name, Parameter(name, Parameter.Type.STRING_ARRAY, [])).value
        return [str(v) for v in value or []]

    def _model(self, values: dict[str, Value]) -> JointModel:
        """The model of the file or of the parameters. Raises ConfigurationError."""
        if values["model_file"]:
            model = read_joint_model(Path(str(values["model_file"])).expanduser())
            for name, parameters in model.effects.items():
                check_effect_parameters(name, dict(parameters))
            return model
        given: dict[str, float] = {}
        for key in dict.fromkeys((*FLEXIBLE_KEYS, *RIGID_KEYS)):
            setting = Setting(key, math.nan, f"model parameter {key} (SI, link side)")
            value = self._number(setting)
            if value is not None:
                given[key] = value
        effects: dict[str, dict[str, float]] = {}
        for effect in CATALOGUE.values():
            for p in effect.parameters:
                setting = Setting(f"effects.{effect.name}.{p.name}", math.nan, f"{p.meaning}, {p.unit}")
                value = self._number(setting)
                if value is not None:
                    effects.setdefault(effect.name, {})[p.name] = value
        for name, parameters in effects.items():
            check_effect_parameters(name, parameters)
        if "J" in given:
            return JointModel(given, effects, str(values["joint"]))
        return JointModel({**COBOT_JOINT.parameters, **given}, effects, str(values["joint"]))

    def _number(self, setting: Setting) -> float | None:
        """An optional number: None when it is not given."""
        described = ParameterDescriptor(description=setting.description, dynamic_typing=True)
        value = self.declare_parameter(setting.key, None, described).value
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ConfigurationError(f"{setting.key} is {value!r}: expected a number.")
        return float(value)

    def _on_parameters(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == "fault" and parameter.value in FAULTS:
                self._fault = str(parameter.value)

    def _on_forward(self, message: Float64MultiArray) -> None:
        if len(message.data) >= 1 and math.isfinite(message.data[0]):
            self._trajectory = None
            self._command = message.data[0]

    def _on_trajectory(self, message: JointTrajectory) -> None:
        if self.names[0] in message.joint_names and message.points:
            self._trajectory = TrajectoryCommand(message, self.names[0], self._joint.time, self._command)

    def _run(self) -> None:
        rate, speed = float(self._values["rate_hz"]), float(self._values["speed"])
        begin = time.monotonic()
        origin = self.get_clock().now().nanoseconds
        frozen: Any = None
        done = 0
        state = JointState(name=self.names)
        link = JointState(name=self.names[:1])
        others = len(self.names) - 1
        while not self._stopping.is_set():
            due = int((time.monotonic() - begin) * rate * speed)
            if done >= due:
                time.sleep(max(0.0, begin + (done + 1) / (rate * speed) - time.monotonic()))
                continue
            for _ in range(min(due - done, 200)):
                if self._trajectory is not None:
                    self._command = self._trajectory.at(self._joint.time)
                measured = self._joint.step(self._command)
                stamp = origin + round(measured.time * 1e9)
                done += 1
                fault = self._fault
                if fault == "stop":
                    continue
                if fault == "time_jump":
                    stamp += 5_000_000_000
                if fault == "freeze":
                    frozen = frozen or measured
                    measured = frozen
                else:
                    frozen = None
                position = math.nan if fault == "nan" else measured.motor_position
                keep = fault != "lose_joint"
                state.name = self.names if keep else self.names[1:]
                own = 1 if keep else 0
                state.header.stamp.sec, state.header.stamp.nanosec = divmod(stamp, 1_000_000_000)
                state.position = [position] * own + [0.5] * others
                state.velocity = [measured.motor_velocity] * own + [0.0] * others
                state.effort = [measured.motor_torque] * own + [0.0] * others
                try:
                    self._states.publish(state)
                    if self._links is not None:
                        link.header.stamp = state.header.stamp
                        link.position = [measured.link_position]
                        self._links.publish(link)
                except Exception:  # the context was shut down between two samples
                    return

    def _urdf(self, values: dict[str, Value]) -> str:
        joints = []
        for i, name in enumerate(self.names):
            joints.append(
                f'<link name="link_{i + 1}"/><joint name="{name}" type="revolute"><parent link="link_{i}"/>'
                f'<child link="link_{i + 1}"/><axis xyz="0 0 1"/><limit lower="{values["limits.position_min"]}" '
                f'upper="{values["limits.position_max"]}" velocity="{values["limits.velocity"]}" '
                f'effort="{values["limits.effort"]}"/></joint>'
            )
        return f'<robot name="virtual"><link name="link_0"/>{"".join(joints)}</robot>'


def main(arguments: list[str] | None = None) -> int:
    """The console script; returns the exit status."""

    def run(node: SimulatedJoint) -> int:
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        node.begin()
        try:
            executor.spin()
        finally:
            node.end()
        return 0

    return run_node("simulated_joint", SimulatedJoint, run, arguments)


if __name__ == "__main__":
    sys.exit(main())
