"""The parameters of `chirp_exciter`, and what they make."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.validate_topic_name import validate_topic_name

from flex_ident.configuration.settings import Setting, Value
from flex_ident.errors import ConfigurationError
from flex_ident.excitation import ChirpSettings, ExciterSettings, Gains, Limits, Reference, chirp_reference
from flex_ident.excitation.chirp import PROFILES, SWEEPS
from flex_ident.excitation.commands import INTERFACES
from flex_ident.excitation.limits import gravity_rest
from flex_ident.nodes.command_messages import JOINTS
from flex_ident.nodes.declared import declare, origin, refuse_unknown
from flex_ident.nodes.usage import Usage

COMMAND_TYPES = ("forward_command", "joint_trajectory")
UNLIMITED = 1e9
FIXED_SETTINGS = (
    Setting("auto_start", False, "start as soon as everything is ready"),
    Setting("exit_when_done", True, "end the node when the chirp is over"),
    Setting("command.type", "forward_command", "which controller takes the commands", choices=COMMAND_TYPES),
    Setting("command.topic", "forward_position_controller/commands", "where commands go"),
)
SETTINGS = (
    Setting("joint", "", "the joint that moves; all others hold"),
    Setting("rate_hz", 500.0, "rate of commands, Hz; the sweep may go up to a tenth of it", lower=10.0, upper=5000.0),
    Setting("mx", 0.0, "first moment MX, kg m, for start_position gravity_rest", lower=-1e6, upper=1e6),
    Setting("my", 0.0, "first moment MY, kg m, for start_position gravity_rest", lower=-1e6, upper=1e6),
    Setting("approach_velocity", 0.2, "largest speed on the way to the start position, rad/s", lower=1e-3, upper=10.0),
    Setting("inertia", 0.0, "expected inertia, kg m^2, to check the effort before moving; 0: unknown", lower=0.0,
            upper=1e6),
    Setting("command.interface", "position", "what is commanded", choices=INTERFACES),
    Setting("command.position_gain", 5.0, "velocity: 1/s; effort: N m/rad around the reference", lower=0.0, upper=1e6),
    Setting("command.velocity_gain", 0.0, "effort: N m s/rad around the reference", lower=0.0, upper=1e6),
    Setting("command.carry_effort", True, "effort: what the joints exert at rest is commanded on; false for robots "
            "that bear gravity on their own"),
    Setting("chirp.start_frequency_hz", 0.05, "where the sweep starts, Hz", lower=1e-3, upper=500.0),
    Setting("chirp.end_frequency_hz", 30.0, "where the sweep ends, Hz", lower=1e-3, upper=500.0),
    Setting("chirp.duration_s", 60.0, "duration of one sweep, s", lower=1.0, upper=3600.0),
    Setting("chirp.amplitude", 0.1, "amplitude at the sweep's start, rad", lower=1e-6, upper=100.0),
    Setting("chirp.profile", "constant_velocity", "what stays constant over the sweep; rich: slow sine, chirp, small "
            "chirp, twice at least", choices=PROFILES),
    Setting("chirp.sweep", "logarithmic", "how the frequency grows", choices=SWEEPS),
    Setting("chirp.fade_s", 1.0, "cosine fade at both ends, s", lower=0.0, upper=60.0),
    Setting("chirp.repeats", 1.0, "how often the sweep is played, a whole number", lower=1.0, upper=100.0),
    Setting("limits.position_min", -UNLIMITED, "lower bound of the position, rad; the tighter of this and the URDF's",
            lower=-UNLIMITED, upper=UNLIMITED),
    Setting("limits.position_max", UNLIMITED, "upper bound of the position, rad; the tighter of this and the URDF's",
            lower=-UNLIMITED, upper=UNLIMITED),
    Setting("limits.velocity", UNLIMITED, "largest speed, rad/s; the tighter of this and the URDF's", lower=1e-6,
            upper=UNLIMITED),
    Setting("limits.effort", UNLIMITED, "largest effort, in the unit of the joint states; the tighter of this and the "
            "URDF's", lower=1e-6, upper=UNLIMITED),
    Setting("limits.tracking_error", 0.2, "largest distance between reference and position, rad", lower=1e-6,
            upper=UNLIMITED),
    Setting("limits.state_timeout_s", 0.1, "oldest joint state that counts, s", lower=1e-3, upper=10.0),
    Setting("limits.require_urdf", False, "refuse to move without robot_description, whatever limits are given"),
    Setting("recording.directory", "flex_ident_recordings", "where the bag is written; empty: no recording; at run "
            "time only a folder inside the one given at the start"),
    Setting("recording.storage", "mcap", "format of the bag", choices=("mcap", "sqlite3")),
    Setting("recording.require_effort", True, "refuse to move where the joint states hold no effort or come too slowly "
            "for the chirp; false: effort is on another recorded topic"),
    Setting("recording.least_free_mib", 200.0, "free space below which nothing is recorded, MiB", lower=1.0, upper=1e6),
)  # fmt: skip
START = "start_position"
START_TEXT = "where the chirp starts: a number in rad, current, or gravity_rest (eq. 17, with mx and my)"
TOPICS = "recording.topics"
NAME_LISTS = {
    JOINTS: ("joints in the order of the controller's; those that do not move are held; empty: the joint alone", [""]),
    TOPICS: ("further topics to record, byte for byte, of any installed type", ["link_joint_states"]),
}
POSITION_GAINS, VELOCITY_GAINS = "command.hold_position_gains", "command.hold_velocity_gains"
NUMBER_LISTS = {
    POSITION_GAINS: "effort: N m/rad that hold the other joints, in the order of command.joints without the one moving",
    VELOCITY_GAINS: "effort: N m s/rad that hold the other joints, in the same order",
}
USAGE = Usage(
    "chirp_exciter",
    "Moves one joint along a chirp, the others held, and records the run as a rosbag2. Nothing moves before a call of "
    "~/start (std_srvs/Trigger), unless auto_start is true; ~/stop ramps down.",
    (*SETTINGS, *FIXED_SETTINGS),
    {START: f"{START_TEXT} [current]", **{key: f"{text} [{default}]" for key, (text, default) in NAME_LISTS.items()},
     **NUMBER_LISTS},
)  # fmt: skip
OPEN = ("limits.position_min", "limits.position_max", "limits.velocity")
"""Limits that must be known before a joint moves."""


@dataclass(frozen=True)
class Experiment:
    """All parameters, checked, and what they make; a URDF tightens `limits`. Raises ConfigurationError."""

    values: dict[str, Any]
    exciter: ExciterSettings = field(init=False)
    reference: Reference = field(init=False)
    limits: Limits = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "limits", limits_of(self.values))
        object.__setattr__(self, "exciter", exciter_of(self.values))
        object.__setattr__(self, "reference", chirp_reference(chirp_of(self.values)))

    @property
    def open_limits(self) -> tuple[str, ...]:
        """Keys of the limits that the parameters leave open and that must be known."""
        return tuple(key for key in OPEN if abs(self.values[key]) >= UNLIMITED)


def declare_all(node: Node) -> None:
    """Declare every parameter. Raises ConfigurationError for those that are wrong or unknown."""
    declare(node, FIXED_SETTINGS, read_only=True)
    declare(node, SETTINGS)
    node.declare_parameter(START, "current", ParameterDescriptor(description=START_TEXT, dynamic_typing=True))
    for key, (text, default) in NAME_LISTS.items():
        given = node._parameter_overrides.get(key)
        empty = given is not None and given.type_ == Parameter.Type.NOT_SET
        if empty:
            node._parameter_overrides.pop(key)
        elif given is not None and given.type_ != Parameter.Type.STRING_ARRAY:
            raise ConfigurationError(f"{origin(node, key)}: {key} is {given.value!r}: expected a list of texts.")
        node.declare_parameter(key, [""] if empty else default, ParameterDescriptor(description=text))
    for key, text in NUMBER_LISTS.items():
        node.declare_parameter(key, None, ParameterDescriptor(description=text, dynamic_typing=True))
    refuse_unknown(node)
    refuse_simulated_time(node.get_parameter("use_sim_time").value)


def refuse_simulated_time(wanted: object) -> None:
    """Refuse to play in a time that may run faster, slower or back. Raises ConfigurationError."""
    if wanted:
        raise ConfigurationError(
            "use_sim_time is true: chirps are played in the computer's own time, in which speeds and limits hold: set "
            "it false, and run the simulator in real time."
        )


def experiment(node: Node, changes: Iterable[Parameter] = ()) -> Experiment:
    """The parameters as they are now, or would be after `changes`. Raises ConfigurationError."""
    changed = {p.name: p.value for p in changes}

    def value(key: str) -> Any:
        return changed[key] if key in changed else node.get_parameter(key).value

    refuse_simulated_time(changed.get("use_sim_time"))
    values: dict[str, Any] = {s.key: s.checked(value(s.key), node.get_name()) for s in (*FIXED_SETTINGS, *SETTINGS)}
    values[START] = value(START)
    values |= {key: [str(v) for v in value(key) or () if v] for key in NAME_LISTS}
    for topic in values[TOPICS]:
        try:
            validate_topic_name(topic)
        except InvalidTopicNameException as error:
            raise ConfigurationError(
                f"{TOPICS}: '{topic}' is no topic's name ({str(error).splitlines()[0]})."
            ) from None
    values |= {key: _numbers(key, value(key)) for key in NUMBER_LISTS}
    return Experiment(values)


def _numbers(key: str, value: object) -> tuple[float, ...]:
    if value is None:
        return ()
    try:
        return tuple(float(v) for v in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        raise ConfigurationError(f"{key} is {value!r}: expected a list of numbers.") from None


def finite_limit(value: Value) -> float:
    """A limit, infinite where the parameter stands for none."""
    number = float(value)
    return math.copysign(math.inf, number) if abs(number) >= UNLIMITED else number


def limits_of(values: dict[str, Any]) -> Limits:
    """The limits in the parameters. Raises ConfigurationError."""
    return Limits(
        finite_limit(values["limits.position_min"]), finite_limit(values["limits.position_max"]),
        finite_limit(values["limits.velocity"]), finite_limit(values["limits.effort"]),
        finite_limit(values["limits.tracking_error"]),
    )  # fmt: skip


def chirp_of(values: dict[str, Any]) -> ChirpSettings:
    """The chirp in the parameters. Raises ConfigurationError."""
    repeats = values["chirp.repeats"]
    if repeats != round(repeats):
        raise ConfigurationError(f"chirp.repeats is {repeats}: expected a whole number.")
    return ChirpSettings(
        values["chirp.start_frequency_hz"], values["chirp.end_frequency_hz"], values["chirp.duration_s"],
        values["chirp.amplitude"], values["chirp.profile"], values["chirp.sweep"], values["chirp.fade_s"],
        round(repeats),
    )  # fmt: skip


def start_of(values: dict[str, Any]) -> float | None:
    """The start position in the parameters; None: where the joint is. Raises ConfigurationError."""
    text = str(values[START]).strip()
    if text == "current":
        return None
    if text == "gravity_rest":
        middle = 0.5 * (values["limits.position_min"] + values["limits.position_max"])
        return gravity_rest(values["mx"], values["my"], middle if abs(middle) < math.tau else 0.0)
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if isinstance(values[START], bool) or not math.isfinite(number):
        raise ConfigurationError(f"{START} is {text}: expected a number in rad, current or gravity_rest.")
    return number


def exciter_of(values: dict[str, Any]) -> ExciterSettings:
    """The exciter's settings in the parameters. Raises ConfigurationError."""
    joint, joints = values["joint"], values[JOINTS]
    if joints and joint not in joints:
        raise ConfigurationError(f"{JOINTS} {joints} does not hold the joint '{joint}'.")
    if len(set(joints)) != len(joints):
        raise ConfigurationError(f"{JOINTS} {joints} names a joint twice.")
    # A trajectory is of positions, whatever the controller makes of them.
    trajectory = values["command.type"] == "joint_trajectory"
    return ExciterSettings(
        joint=joint, interface="position" if trajectory else values["command.interface"], rate_hz=values["rate_hz"],
        start_position=start_of(values), state_timeout_s=values["limits.state_timeout_s"],
        approach_velocity=values["approach_velocity"],
        gains=Gains(values["command.position_gain"], values["command.velocity_gain"], values[POSITION_GAINS],
                    values[VELOCITY_GAINS]),
        inertia=values["inertia"], carry_effort=values["command.carry_effort"],
        held=tuple(j for j in joints if j != joint),
    )  # fmt: skip
