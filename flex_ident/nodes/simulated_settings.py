"""The parameters of `simulated_joint`, and what they make."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from flex_ident.configuration.settings import Setting, Value
from flex_ident.effects import check_effect_parameters
from flex_ident.effects.catalogue import CATALOGUE
from flex_ident.effects.curve import TORQUE, Curve
from flex_ident.effects.effect import Effect
from flex_ident.errors import ConfigurationError
from flex_ident.nodes.declared import current, declare, refuse_unknown
from flex_ident.nodes.usage import Usage
from flex_ident.parameters import FLEXIBLE_KEYS, RIGID_KEYS, UNITS, JointModel, read_joint_model
from flex_ident.parameters.keys import key_text
from flex_ident.parameters.parameter import NON_NEGATIVE
from flex_ident.recording.names import at_home
from flex_ident.simulation.terms import MOST_POINTS
from flex_ident.virtual_joint import COBOT_JOINT, INTERFACES, Drive, Instruments, Interface, ample_effort, drive_for

FAULTS = ("none", "stop", "freeze", "nan", "time_jump", "lose_joint")
FAULT = Setting("fault", "none", "a fault to play, for tests: joint states stop, freeze, ...", choices=FAULTS)
SETTINGS = (
    Setting("joint", "joint_1", "name of the joint that moves"),
    Setting("rate_hz", 1000.0, "rate of the joint states, Hz", lower=10.0, upper=10000.0),
    Setting("speed", 1.0, "faster than real time by this factor; stamps follow", lower=0.01, upper=100.0),
    Setting("seed", 0.0, "seed of the noise", lower=0.0, upper=2.0**31),
    Setting("link_encoder", True, "publish link_joint_states"),
    Setting("start_position", 0.0, "motor position at the start, rad", lower=-100.0, upper=100.0),
    Setting("controller.type", "forward_command", "how commands come", choices=("forward_command", "joint_trajectory")),
    Setting("controller.interface", "position", "what is commanded", choices=INTERFACES),
    Setting("controller.topic", "forward_position_controller/commands", "where commands come from"),
    Setting("controller.smoothing_hz", 40.0, "position commands are smoothed at this frequency", lower=1.0,
            upper=1000.0),
    Setting("noise.motor_bits", 20.0, "bits a turn of the motor encoder", lower=8.0, upper=32.0),
    Setting("noise.link_bits", 20.0, "bits a turn of the link encoder", lower=8.0, upper=32.0),
    Setting("noise.torque", 0.2, "standard deviation of the torque reading, N m", lower=0.0, upper=1e6),
    Setting("noise.torque_disturbance", 0.0, "standard deviation of a torque that acts unrecorded, N m", lower=0.0,
            upper=1e6),
    Setting("limits.position_min", -3.1, "lower limit in robot_description, rad", lower=-1e3, upper=1e3),
    Setting("limits.position_max", 3.1, "upper limit in robot_description, rad", lower=-1e3, upper=1e3),
    Setting("limits.velocity", 3.0, "speed limit in robot_description, rad/s", lower=1e-3, upper=1e3),
    Setting("limits.effort", 0.0, "effort limit of the drive, N m; 0: ample for the model", lower=0.0, upper=1e9),
)  # fmt: skip
LISTS = {
    "other_joints": "further joints that stand still and take no commands",
    "controller.joints": "joints in the order of a forward command; empty: joint, then other_joints",
}
TABLES = {
    f"effects.{effect.name}.{name}": f"{effect.summary}: {name} at its points"
    for effect in CATALOGUE.values() if effect.curve is not None for name in (effect.curve.at, TORQUE)
}  # fmt: skip
MODEL_FILE = Setting("model_file", "", "a model.yaml; single parameters win over it; without it a cobot's joint")
RIGID = Setting(
    "J", 0.0, "inertia of a joint without a spring, kg m^2; 0: the joint has a spring", lower=0.0, upper=1e9
)
HELD_AT = 0.5
"""Where the other joints stand, rad."""


def declared_values(node: Node) -> tuple[dict[str, Value], JointModel]:
    """All parameters, declared and checked, and the model. Raises ConfigurationError, naming key and range."""
    values = _declared(node, SETTINGS)
    values |= _declared(node, (FAULT,), read_only=False)
    for key, text in LISTS.items():
        node.declare_parameter(key, [""], ParameterDescriptor(description=text, read_only=True))
    model = _model(node, str(values["joint"]))
    refuse_unknown(node)
    low, high = float(values["limits.position_min"]), float(values["limits.position_max"])
    if not low < high:
        raise ConfigurationError(f"limits.position_min {low} is not below limits.position_max {high}.")
    if values["controller.type"] == "joint_trajectory" and values["controller.interface"] != "position":
        raise ConfigurationError("controller.type joint_trajectory takes controller.interface position.")
    values["limits.effort"] = float(values["limits.effort"]) or ample_effort(model)
    return values, model


def joint_names(node: Node, values: dict[str, Value]) -> tuple[list[str], list[str]]:
    """The joints published, the moving one first, and those of a forward command. Raises ConfigurationError."""
    joint = str(values["joint"])
    others = [name for name in node.get_parameter("other_joints").value if name]
    if not joint or len({joint, *others}) != 1 + len(others):
        raise ConfigurationError(f"joint '{joint}' and other_joints {others} must be names that differ.")
    commanded = [name for name in node.get_parameter("controller.joints").value if name] or [joint, *others]
    if joint not in commanded:
        raise ConfigurationError(f"controller.joints {commanded} does not hold the joint '{joint}'.")
    return [joint, *others], commanded


def drive_of(model: JointModel, values: dict[str, Value]) -> Drive:
    """The drive: without the feedforward of acceleration, which commands that come unevenly would make noise of."""
    interface: Interface = str(values["controller.interface"])  # type: ignore[assignment]
    drive = drive_for(model, effort_limit=float(values["limits.effort"]), interface=interface)
    return replace(drive, inertia=0.0, smoothing_hz=float(values["controller.smoothing_hz"]))


def instruments_of(values: dict[str, Value]) -> Instruments:
    """Encoders and torque reading."""
    turn = 2.0 * math.pi
    return Instruments(
        turn / 2.0 ** float(values["noise.motor_bits"]), turn / 2.0 ** float(values["noise.link_bits"]),
        float(values["noise.torque"]), float(values["noise.torque_disturbance"]),
    )  # fmt: skip


def description_of(names: list[str], values: dict[str, Value]) -> str:
    """A chain of the joints as URDF, all with the same limits."""
    limit = (
        f'<limit lower="{values["limits.position_min"]}" upper="{values["limits.position_max"]}" '
        f'velocity="{values["limits.velocity"]}" effort="{values["limits.effort"]}"/>'
    )
    joints = "".join(
        f'<link name="link_{i + 1}"/><joint name="{name}" type="revolute"><parent link="link_{i}"/>'
        f'<child link="link_{i + 1}"/><axis xyz="0 0 1"/>{limit}</joint>'
        for i, name in enumerate(names)
    )
    return f'<robot name="virtual"><link name="link_0"/>{joints}</robot>'


def _declared(node: Node, settings: Iterable[Setting], *, read_only: bool = True) -> dict[str, Value]:
    """Values of settings, declared and checked."""
    settings = tuple(settings)
    declare(node, settings, read_only=read_only)
    return current(node, settings)


def _model(node: Node, joint: str) -> JointModel:
    """The model of the file, or a cobot's joint, with the parameters given singly."""
    file = str(_declared(node, (MODEL_FILE,))["model_file"])
    base = read_joint_model(at_home(file)) if file else COBOT_JOINT
    for name, parameters in base.effects.items():
        check_effect_parameters(name, dict(parameters))
    rigid = float(_declared(node, (replace(RIGID, default=base.value("J")),))["J"])
    keys = [key for key in (RIGID_KEYS if rigid else FLEXIBLE_KEYS) if key != "J"]
    if bool(rigid) != base.rigid:
        base = JointModel({"J": rigid}) if rigid else COBOT_JOINT
    parameters = {key: float(value) for key, value in _declared(node, model_settings(keys, base)).items()}
    if rigid:
        parameters["J"] = rigid
    effects = {effect.name: _effect(node, effect, base) for effect in CATALOGUE.values()}
    return JointModel(parameters, {name: p for name, p in effects.items() if p}, joint)


def model_settings(keys: Sequence[str], base: JointModel) -> list[Setting]:
    """Single parameters of the model; the defaults are those of `base`."""
    return [
        Setting(key, base.value(key), f"parameter {key} of the model, {UNITS[key]}",
                lower=0.0 if key in NON_NEGATIVE else -1e9, upper=1e9)
        for key in keys
    ]  # fmt: skip


def effect_settings(effect: Effect, base: JointModel) -> list[Setting]:
    """Parameters of one effect; the defaults are those of `base`, 0 where it has none."""
    return [
        Setting(f"effects.{effect.name}.{p.name}", base.value(key_text(effect.name, p.name)), f"{p.meaning}, {p.unit}",
                lower=max(min(p.lower, 0.0), -1e9), upper=min(p.upper, 1e9))
        for p in effect.parameters
    ]  # fmt: skip


def _table(node: Node, effect: Effect, curve: Curve, base: JointModel) -> dict[str, float]:
    """The parameters of an effect that is a table, from two lists; none where both are empty or a zero alone.

    Raises ConfigurationError.
    """
    rows = []
    for name, default in zip((curve.at, TORQUE), curve.table_in(base.effects.get(effect.name, {})), strict=True):
        key = f"effects.{effect.name}.{name}"
        text = f"{TABLES[key]}; 0 alone: none"
        node.declare_parameter(key, default.tolist() or [0.0], ParameterDescriptor(description=text, read_only=True))
        rows.append([float(x) for x in node.get_parameter(key).value])
    if rows == [[0.0], [0.0]]:
        return {}
    if len(rows[0]) != len(rows[1]) or len(rows[0]) > MOST_POINTS:
        raise ConfigurationError(
            f"effects.{effect.name} has {len(rows[0])} values of {curve.at} and {len(rows[1])} of {TORQUE}: expected "
            f"as many, {MOST_POINTS} at most."
        )
    found = curve.parameters_of(np.array(rows[0]), np.array(rows[1]))
    check_effect_parameters(effect.name, found)
    return found


def _effect(node: Node, effect: Effect, base: JointModel) -> dict[str, float]:
    """The effect's parameters; none when all are zero. Raises ConfigurationError."""
    if effect.curve is not None:
        return _table(node, effect, effect.curve, base)
    settings = effect_settings(effect, base)
    read = {key.rsplit(".", 1)[1]: float(value) for key, value in _declared(node, settings).items()}
    given = {name: value for name, value in read.items() if value}
    if not given:
        return {}
    sides = {name.endswith("_link") for name in given}
    for p in effect.parameters:
        if p.lower > 0.0 and not read[p.name] and p.name.endswith("_link") in sides:
            raise ConfigurationError(
                f"effects.{effect.name} needs {p.name} ({p.meaning}, {p.unit}) beside {', '.join(given)}."
            )
    wanted = {p.name: read[p.name] for p in effect.parameters if p.name.endswith("_link") in sides}
    check_effect_parameters(effect.name, wanted)
    return wanted


USAGE = Usage(
    "simulated_joint",
    "A virtual robot joint (two masses, a spring, friction, gravity, any effect of the catalogue) that takes the "
    "commands and publishes the topics of a robot.",
    (*SETTINGS, FAULT, MODEL_FILE, *model_settings(FLEXIBLE_KEYS, COBOT_JOINT), RIGID,
     *(s for effect in CATALOGUE.values() if effect.curve is None for s in effect_settings(effect, COBOT_JOINT))),
    {**LISTS, **TABLES},
)  # fmt: skip
