"""The parameters of `chirp_exciter`, and what they make."""

from __future__ import annotations

import math

from flex_ident.configuration.settings import Setting, Value
from flex_ident.errors import ConfigurationError
from flex_ident.excitation import ChirpSettings, ExciterSettings, Limits
from flex_ident.excitation.chirp import PROFILES, SWEEPS
from flex_ident.excitation.exciter import INTERFACES
from flex_ident.excitation.limits import gravity_rest

COMMAND_TYPES = ("forward_command", "joint_trajectory")
UNLIMITED = 1e9
SETTINGS = (
    Setting("joint", "", "the joint that moves; all others hold"),
    Setting("auto_start", False, "start as soon as everything is ready"),
    Setting("exit_when_done", True, "end the node when the chirp is over"),
    Setting("rate_hz", 500.0, "rate of commands", lower=10.0, upper=5000.0),
    Setting("start_position", "current", "where the chirp starts: a number in rad, current, or gravity_rest (eq. 17, "
            "with mx and my)"),
    Setting("mx", 0.0, "first moment MX, kg m, for start_position gravity_rest", lower=-1e6, upper=1e6),
    Setting("my", 0.0, "first moment MY, kg m, for start_position gravity_rest", lower=-1e6, upper=1e6),
    Setting("approach_velocity", 0.2, "largest speed on the way to the start position, rad/s", lower=1e-3, upper=10.0),
    Setting("inertia", 0.0, "expected inertia, kg m^2, to check the effort before moving; 0: unknown", lower=0.0,
            upper=1e6),
    Setting("command.type", "forward_command", "which controller takes the commands", choices=COMMAND_TYPES),
    Setting("command.interface", "position", "what is commanded", choices=INTERFACES),
    Setting("command.topic", "/forward_position_controller/commands", "where commands go"),
    Setting("command.position_gain", 5.0, "velocity: 1/s; effort: N m/rad around the reference", lower=0.0, upper=1e6),
    Setting("command.velocity_gain", 0.0, "effort: N m s/rad around the reference", lower=0.0, upper=1e6),
    Setting("chirp.start_frequency_hz", 0.05, "where the sweep starts, Hz", lower=1e-3, upper=1000.0),
    Setting("chirp.end_frequency_hz", 30.0, "where the sweep ends, Hz", lower=1e-3, upper=1000.0),
    Setting("chirp.duration_s", 60.0, "duration of one sweep, s", lower=1.0, upper=36000.0),
    Setting("chirp.amplitude", 0.1, "amplitude at the sweep's start, rad", lower=1e-6, upper=100.0),
    Setting("chirp.profile", "constant_velocity", "what stays constant over the sweep; rich: slow sine, chirp, small "
            "chirp", choices=PROFILES),
    Setting("chirp.sweep", "logarithmic", "how the frequency grows", choices=SWEEPS),
    Setting("chirp.fade_s", 1.0, "cosine fade at both ends, s", lower=0.0, upper=60.0),
    Setting("chirp.repeats", 1.0, "how often the sweep is played", lower=1.0, upper=100.0),
    Setting("limits.position_min", -UNLIMITED, "lower bound of the position, rad", lower=-UNLIMITED, upper=UNLIMITED),
    Setting("limits.position_max", UNLIMITED, "upper bound of the position, rad", lower=-UNLIMITED, upper=UNLIMITED),
    Setting("limits.velocity", UNLIMITED, "largest speed, rad/s", lower=1e-6, upper=UNLIMITED),
    Setting("limits.effort", UNLIMITED, "largest effort, N m", lower=1e-6, upper=UNLIMITED),
    Setting("limits.tracking_error", 0.2, "largest distance between reference and position, rad", lower=1e-6,
            upper=UNLIMITED),
    Setting("limits.state_timeout_s", 0.1, "oldest joint state that counts, s", lower=1e-3, upper=10.0),
    Setting("limits.require_urdf", False, "refuse to move without /robot_description"),
    Setting("recording.directory", "flex_ident_recordings", "where the bag is written; empty: no recording"),
    Setting("recording.storage", "mcap", "format of the bag", choices=("mcap", "sqlite3")),
)  # fmt: skip
LISTS = {
    "recording.topics": ("further topics to record", ["/link_joint_states"]),
    "command.joints": ("joints in the order of a forward command; empty: the joint alone", [""]),
}


def finite_limit(value: Value) -> float:
    """A limit, infinite where the parameter stands for none."""
    number = float(value)
    return math.copysign(math.inf, number) if abs(number) >= UNLIMITED else number


def limits_of(values: dict[str, Value]) -> Limits:
    """The limits in the parameters. Raises ConfigurationError."""
    return Limits(
        finite_limit(values["limits.position_min"]), finite_limit(values["limits.position_max"]),
        finite_limit(values["limits.velocity"]), finite_limit(values["limits.effort"]),
        finite_limit(values["limits.tracking_error"]),
    )  # fmt: skip


def chirp_of(values: dict[str, Value]) -> ChirpSettings:
    """The chirp in the parameters. Raises ConfigurationError."""
    return ChirpSettings(
        float(values["chirp.start_frequency_hz"]), float(values["chirp.end_frequency_hz"]),
        float(values["chirp.duration_s"]), float(values["chirp.amplitude"]), str(values["chirp.profile"]),
        str(values["chirp.sweep"]), float(values["chirp.fade_s"]), round(float(values["chirp.repeats"])),
    )  # fmt: skip


def start_of(values: dict[str, Value]) -> float | None:
    """The start position in the parameters; None: where the joint is. Raises ConfigurationError."""
    text = str(values["start_position"]).strip()
    if text == "current":
        return None
    if text == "gravity_rest":
        return gravity_rest(float(values["mx"]), float(values["my"]), 0.0)
    try:
        return float(text)
    except ValueError:
        raise ConfigurationError(f"start_position is '{text}': expected a number, current or gravity_rest.") from None


def exciter_of(values: dict[str, Value]) -> ExciterSettings:
    """The exciter's settings in the parameters. Raises ConfigurationError."""
    return ExciterSettings(
        joint=str(values["joint"]), interface=str(values["command.interface"]), rate_hz=float(values["rate_hz"]),
        start_position=start_of(values), state_timeout_s=float(values["limits.state_timeout_s"]),
        approach_velocity=float(values["approach_velocity"]), position_gain=float(values["command.position_gain"]),
        velocity_gain=float(values["command.velocity_gain"]), inertia=float(values["inertia"]),
    )  # fmt: skip
