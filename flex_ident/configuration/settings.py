"""Every setting of an identification once: key, type, range and description, for command line, YAML and node."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flex_ident.errors import ConfigurationError
from flex_ident.parameters.effort_kinds import EFFORT_KINDS
from flex_ident.recording.names import shortened

Value = str | float | bool


@dataclass(frozen=True)
class Setting:
    """A setting: `key` as in YAML; its default says its type (text, number, yes or no).

    Numbers lie in `lower` to `upper`, texts among `choices` where there are any. An empty text and a number of 0 mean
    'not given' where the default is that.
    """

    key: str
    default: Value
    description: str
    choices: tuple[str, ...] = ()
    lower: float = -math.inf
    upper: float = math.inf
    metavar: str = ""
    many: bool = False
    """Whether a text is a list: separated by `separator`, or a list in YAML."""
    separator: str = ","
    repeated: bool = False
    """Whether the option may be given several times: one text of a list each."""

    @property
    def option(self) -> str:
        """The option on the command line."""
        return "--" + self.key.rpartition(".")[2].removesuffix("_hz").replace("_", "-")

    @property
    def range_text(self) -> str:
        """What is allowed, in words."""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        if isinstance(self.default, bool):
            return "true or false"
        if isinstance(self.default, str):
            return "a text"
        if math.isinf(self.lower) and math.isinf(self.upper):
            return "a number"
        return f"a number from {self.lower:g} to {self.upper:g}"

    def checked(self, value: object, where: str) -> Value:
        """`value` in the setting's type. Raises ConfigurationError that names `where` and what is allowed."""
        problem = ConfigurationError(f"{where}: {self.key} is {shortened(value)}: expected {self.range_text}.")
        if isinstance(self.default, bool):
            if not isinstance(value, bool):
                raise problem
            return value
        if self.many and isinstance(value, list) and all(isinstance(own, (str, int)) for own in value):
            value = self.separator.join(str(own) for own in value)
        if isinstance(self.default, str):
            if not isinstance(value, str) or (self.choices and value not in self.choices):
                raise problem
            return value
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise problem
        if not self.lower <= value <= self.upper:
            raise problem
        return float(value)


PLACE = "TOPIC[:NAME[.FIELD]]"

IDENTIFY_SETTINGS: tuple[Setting, ...] = (
    Setting("joint", "", "the joint to identify; without it the only joint that moves"),
    Setting("motor_position", "", "where the motor position is", metavar=PLACE),
    Setting("link_position", "", "where the link position is", metavar=PLACE),
    Setting("effort", "", "where the effort is", metavar=PLACE),
    Setting("reference", "", "where the commanded position is", metavar=PLACE),
    Setting(
        "motor_current", "", "where the motor's current is, beside the effort of a joint torque sensor", metavar=PLACE
    ),
    Setting("type_file", "", "what defines a message type that the bag does not: X.msg, or a folder of such; several "
            "separated by commas", metavar="X.msg", many=True),
    Setting("effort_scale", 1.0, "N m per recorded unit of effort (torque constant x gear ratio); negative turns the "
            "sign", lower=-1e6, upper=1e6, metavar="X"),
    Setting("effort_kind", "auto", "what the effort is: the motor's torque, that through the gear from a sensor, that "
            "less the gravity which the controller adds; auto finds out", choices=EFFORT_KINDS),
    Setting("urdf", "", "the robot's URDF (xacro expanded, its root upright): which way gravity pulls on this joint, "
            "and whether the effort holds it", metavar="FILE"),
    Setting("gear_ratio", 1.0, "motor turns per link turn, when the motor position is on the motor shaft",
            lower=-1e5, upper=1e5, metavar="N"),
    Setting("sensors", "auto", "which model: motor position alone, or motor and link position",
            choices=("auto", "motor", "motor+link")),
    Setting("method", "auto", "auto: the best there is; paper: the 2001 paper to the letter; weighted: its equations "
            "with clean preprocessing and weights", choices=("auto", "paper", "weighted")),
    Setting("rigid", False, "no spring: J, FV, FS, offset, and MX, MY where they show"),
    Setting("first_mode_hz", 0.0, "the first natural frequency, if known; otherwise it is found", lower=0.0, upper=1e4,
            metavar="HZ"),
    Setting("band_hz", 0.0, "up to which frequency to compare; otherwise as far as motion and torque are coherent",
            lower=0.0, upper=1e4, metavar="HZ"),
    Setting("model", "", "a model.yaml to start from", metavar="FILE"),
    Setting("cutoff_sweep", False, "repeat the fit at other cutoffs and plot each estimate against them"),
    Setting("prismatic", False, "a prismatic joint: N, m, kg"),
    Setting("out", "", "where to write; default ./flex_ident_results/BAGNAME_JOINT", metavar="DIR"),
)  # fmt: skip

GAP_SETTINGS: tuple[Setting, ...] = (
    Setting("without", "", "base parameters to drop, MX,MY", metavar="KEYS"),
    Setting("effects", "", "the catalogue restricted to these effects, comma-separated", metavar="LIST"),
    Setting("add", "", "effects put in by hand, comma-separated", metavar="EFFECT"),
    Setting("simulated", "", "a recording of the same experiment from a simulator: what is off in it", metavar="BAG"),
)

SET_SETTINGS: tuple[Setting, ...] = (
    Setting("payload", "", "a known mass, kg, at X, Y metres in the link's frame, in that recording (in all without "
            "BAG): gives the effort's scale", metavar="[BAG=]MASS@X[,Y]", many=True, separator=";", repeated=True),
    Setting("leave_out", "", "a recording of the set to leave out", metavar="BAG", many=True, separator=";",
            repeated=True),
)  # fmt: skip
"""Of several recordings of one joint."""

IMPORT_SETTINGS: tuple[Setting, ...] = (
    Setting("import.joints", "", "names of the joints", metavar="NAMES", many=True),
    Setting("import.time", "", "the column of time", metavar="COLUMN"),
    Setting("import.position", "", "the columns of the joints' motor positions", metavar="COLUMNS", many=True),
    Setting("import.velocity", "", "those of their velocities", metavar="COLUMNS", many=True),
    Setting("import.effort", "", "those of their efforts", metavar="COLUMNS", many=True),
    Setting("import.link_position", "", "those of positions behind the gear", metavar="COLUMNS", many=True),
    Setting("import.reference", "", "those of commanded positions", metavar="COLUMNS", many=True),
    Setting("import.time_scale", 0.0, "seconds per unit of time; otherwise by the unit in the column's name",
            lower=0.0, upper=1e6, metavar="X"),
    Setting("import.position_scale", 0.0, "rad (or m) per unit of position; otherwise by the unit in the column's name",
            lower=-1e6, upper=1e6, metavar="X"),
    Setting("import.velocity_scale", 0.0, "rad/s per unit of velocity; otherwise likewise", lower=-1e6, upper=1e6,
            metavar="X"),
    Setting("import.effort_scale", 0.0, "N m per unit of effort; otherwise likewise", lower=-1e6, upper=1e6,
            metavar="X"),
    Setting("import.rate_hz", 0.0, "samples per second, where there is no column of time", lower=0.0, upper=1e5,
            metavar="HZ"),
    Setting("import.episode", -1.0, "the episode of a LeRobot dataset, from 0", lower=-1.0, upper=1e9, metavar="N"),
)  # fmt: skip
"""How `flex_ident import` reads a table; 0, -1 and an empty text: found out."""
