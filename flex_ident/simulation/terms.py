"""The terms that the simulation knows, as one vector: what base parameters and effects write into."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from flex_ident.parameters.keys import Side
from flex_ident.parameters.parameter import FAR_MODE
from flex_ident.recording import Floats


class Term(IntEnum):
    """Position of each physical term in the vector (SI, link side). Zero switches a term off.

    Declared once: its side, whether it is a force (all forces scaled together leave the motion as it is and scale the
    torque), and for a term that only shapes another the name of that one: it says nothing while that is zero.
    A term is moved into the batch (`batch.LANE_ROWS`) by hand; one that is not there is simulated by itself.
    """

    side: Side
    force: bool
    _of: str

    def __new__(cls, side: Side, force: bool, of: str = "") -> Term:
        """The next term of the vector."""
        term = int.__new__(cls, len(cls.__members__))
        term._value_ = len(cls.__members__)
        term.side, term.force, term._of = side, force, of
        return term

    # the spring between motor and link
    STIFFNESS = "spring", True
    CUBIC_STIFFNESS = "spring", True
    HALF_GAP = "spring", False
    HYSTERESIS_TORQUE = "spring", True
    HYSTERESIS_DEFLECTION = "spring", False, "HYSTERESIS_TORQUE"
    SPRING_DAMPING = "spring", True
    # the link
    LINK_INERTIA = "link", True
    LINK_VISCOUS = "link", True
    LINK_COULOMB = "link", True
    GRAVITY_COS = "link", True
    """First moment times g, N m: multiplies cos q."""
    GRAVITY_SIN = "link", True
    LINK_VISCOUS_ASYMMETRY = "link", True
    LINK_VISCOUS_QUADRATIC = "link", True
    LINK_STRIBECK = "link", True
    LINK_STRIBECK_VELOCITY = "link", False, "LINK_STRIBECK"
    LINK_LOAD_FRICTION = "link", False
    # a further mass on the link
    SECOND_INERTIA = "link", True
    SECOND_STIFFNESS = "link", True, "SECOND_INERTIA"
    SECOND_DAMPING = "link", True, "SECOND_INERTIA"
    # friction on both sides
    FRICTION_RATE = "both", False
    # the motor
    MOTOR_INERTIA = "motor", True
    MOTOR_VISCOUS = "motor", True
    MOTOR_COULOMB = "motor", True
    MOTOR_VISCOUS_ASYMMETRY = "motor", True
    MOTOR_VISCOUS_QUADRATIC = "motor", True
    MOTOR_STRIBECK = "motor", True
    MOTOR_STRIBECK_VELOCITY = "motor", False, "MOTOR_STRIBECK"
    MOTOR_LOAD_FRICTION = "motor", False
    MOTOR_FRICTION_RATE = "motor", False
    OFFSET = "motor", True
    RIPPLE = "motor", True
    RIPPLE_CYCLES = "motor", False, "RIPPLE"
    RIPPLE_PHASE = "motor", False, "RIPPLE"
    # the transmission between motor angle and spring
    KINEMATIC_ERROR = "spring", False
    KINEMATIC_CYCLES = "spring", False, "KINEMATIC_ERROR"
    KINEMATIC_PHASE = "spring", False, "KINEMATIC_ERROR"
    # the measurement chain and the state at the start
    TORQUE_DELAY = "measurement", False
    TORQUE_AVERAGING = "measurement", False
    """kappa in recorded = Gamma + kappa Ts^2 Gamma'': +1/24 for a mean over one sample, -1/24 for a held command."""
    LINK_SKEW = "measurement", False
    LINK_ZERO = "measurement", False
    """Link encoder's zero, rad, against the motor's."""
    TORQUE_LIMIT = "measurement", True
    """Zero: no limit."""
    INITIAL_DEFLECTION = "link", False
    """Deviation of the link's first position from its static equilibrium, rad."""
    INITIAL_VELOCITY = "link", False
    """Deviation of the link's first velocity from the motor's, rad/s."""
    # how the motor's dry friction turns over at a reversal
    REVERSAL_SPEED = "motor", False
    """Speed, rad/s, over which dry friction grows to its full size: zero is Coulomb's law."""
    PRESLIDING = "motor", False
    """Way, rad, over which dry friction turns over after a reversal (Dahl)."""
    REVERSAL_LEAD = "motor", False
    """Time, s, by which dry friction turns over before the velocity does."""
    EFFORT_LAG = "measurement", False
    """Time constant, s, of a first-order low-pass in the recorded torque."""
    GRAVITY_REMOVED = "measurement", False
    """Share of the gravity at the motor's position that the recorded torque is without: the controller adds it."""
    LINK_SCALE = "measurement", False
    """By how much the link encoder reads too far, over what it reads: its scale, or an eccentric disk, locally."""
    # elastic friction of the motor before it slides
    BRISTLE_DEFLECTION = "motor", False
    """Deflection, rad, of the bristles under the dry friction at standstill, of any name."""
    BRISTLE_STRIBECK = "motor", True, "BRISTLE_DEFLECTION"
    BRISTLE_STRIBECK_VELOCITY = "motor", False, "BRISTLE_DEFLECTION"
    # dry friction as a soft constraint of a simulator, on both sides
    SOFT_FRICTION = "both", False
    """Friction is inertia over this, times acceleration and speed over the time, at most the dry friction."""
    SOFT_FRICTION_TIME = "both", False, "SOFT_FRICTION"
    # the base on which the joint stands
    MOUNT_INERTIA = "link", True
    MOUNT_STIFFNESS = "link", True, "MOUNT_INERTIA"
    MOUNT_DAMPING = "link", True, "MOUNT_INERTIA"
    # further harmonics of what is periodic in the motor's angle
    RIPPLE_2 = "motor", True
    RIPPLE_CYCLES_2 = "motor", False, "RIPPLE_2"
    RIPPLE_PHASE_2 = "motor", False, "RIPPLE_2"
    RIPPLE_3 = "motor", True
    RIPPLE_CYCLES_3 = "motor", False, "RIPPLE_3"
    RIPPLE_PHASE_3 = "motor", False, "RIPPLE_3"
    RIPPLE_4 = "motor", True
    RIPPLE_CYCLES_4 = "motor", False, "RIPPLE_4"
    RIPPLE_PHASE_4 = "motor", False, "RIPPLE_4"
    RIPPLE_5 = "motor", True
    RIPPLE_CYCLES_5 = "motor", False, "RIPPLE_5"
    RIPPLE_PHASE_5 = "motor", False, "RIPPLE_5"
    KINEMATIC_ERROR_2 = "spring", False
    KINEMATIC_CYCLES_2 = "spring", False, "KINEMATIC_ERROR_2"
    KINEMATIC_PHASE_2 = "spring", False, "KINEMATIC_ERROR_2"
    KINEMATIC_ERROR_3 = "spring", False
    KINEMATIC_CYCLES_3 = "spring", False, "KINEMATIC_ERROR_3"
    KINEMATIC_PHASE_3 = "spring", False, "KINEMATIC_ERROR_3"
    KINEMATIC_ERROR_4 = "spring", False
    KINEMATIC_CYCLES_4 = "spring", False, "KINEMATIC_ERROR_4"
    KINEMATIC_PHASE_4 = "spring", False, "KINEMATIC_ERROR_4"
    KINEMATIC_ERROR_5 = "spring", False
    KINEMATIC_CYCLES_5 = "spring", False, "KINEMATIC_ERROR_5"
    KINEMATIC_PHASE_5 = "spring", False, "KINEMATIC_ERROR_5"

    FRICTION_REMOVED = "measurement", True
    """Dry friction that the controller adds, N m, and the recorded torque is without: with the tanh of the speed over
    that of `FRICTION_REMOVED_SPEED`, beside what is left of it there."""
    FRICTION_REMOVED_SPEED = "measurement", False, "FRICTION_REMOVED"
    LINK_DRIFT = "measurement", False
    """By how much the clock of the link encoder runs fast against the motor's, s/s; zero in the middle."""
    IRON_LOSS = "measurement", False
    """What the torque delivered is less than the one recorded, over the latter's square, 1/(N m)^2."""
    TORQUE_DROOP = "measurement", False
    """The same over the motor's speed squared, s^2/rad^2."""
    LINK_TURNOVER = "link", False
    """Speed at which the link's dry friction turns over, rad/s, by its tanh; 0: at once."""
    STIFFNESS_COS_2 = "spring", True
    """By how much the stiffness grows with the angle of the motor's side, N m/rad: multiplies cos 2q - 1."""
    STIFFNESS_SIN_2 = "spring", True
    GAIN_RATE = "measurement", False
    """Relative change in a second of what a torque is recorded as, 1/s; none at the start."""
    OFFSET_RATE = "measurement", True
    """Change in a second of what is recorded beside the torque, N m/s; none at the start."""
    CABLE_STIFFNESS = "link", True
    """Of a spring from the link to ground, N m/rad: multiplies the link's position."""
    CABLE_TORQUE = "link", True
    """What it pulls with where the position is zero, N m."""
    CABLE_COS_2 = "link", True
    """What a spring on a lever adds, N m: multiplies the cosine of twice the link's position."""
    CABLE_SIN_2 = "link", True
    # the motor's dry friction over its angle: harmonics
    FRICTION_WAVE = "motor", True
    FRICTION_WAVE_CYCLES = "motor", False, "FRICTION_WAVE"
    FRICTION_WAVE_PHASE = "motor", False, "FRICTION_WAVE"
    FRICTION_WAVE_2 = "motor", True
    FRICTION_WAVE_CYCLES_2 = "motor", False, "FRICTION_WAVE_2"
    FRICTION_WAVE_PHASE_2 = "motor", False, "FRICTION_WAVE_2"
    FRICTION_WAVE_3 = "motor", True
    FRICTION_WAVE_CYCLES_3 = "motor", False, "FRICTION_WAVE_3"
    FRICTION_WAVE_PHASE_3 = "motor", False, "FRICTION_WAVE_3"
    FRICTION_WAVE_4 = "motor", True
    FRICTION_WAVE_CYCLES_4 = "motor", False, "FRICTION_WAVE_4"
    FRICTION_WAVE_PHASE_4 = "motor", False, "FRICTION_WAVE_4"
    FRICTION_WAVE_5 = "motor", True
    FRICTION_WAVE_CYCLES_5 = "motor", False, "FRICTION_WAVE_5"
    FRICTION_WAVE_PHASE_5 = "motor", False, "FRICTION_WAVE_5"
    # a spring that is softer at small torque
    SOFT_ZONE_SHARE = "spring", False
    """Share of the stiffness that is missing at no torque."""
    SOFT_ZONE_DEFLECTION = "spring", False, "SOFT_ZONE_SHARE"
    """Deflection, rad, up to which it is."""
    # a part of the spring that relaxes
    RELAXING_STIFFNESS = "spring", True
    RELAXATION_TIME = "spring", False, "RELAXING_STIFFNESS"
    # encoders that err with their own angle: harmonics
    MOTOR_ENCODER_ERROR = "both", False
    """What the motor's encoder reads too far, rad: motor and link move otherwise than it says."""
    MOTOR_ENCODER_CYCLES = "both", False, "MOTOR_ENCODER_ERROR"
    MOTOR_ENCODER_PHASE = "both", False, "MOTOR_ENCODER_ERROR"
    MOTOR_ENCODER_ERROR_2 = "both", False
    MOTOR_ENCODER_CYCLES_2 = "both", False, "MOTOR_ENCODER_ERROR_2"
    MOTOR_ENCODER_PHASE_2 = "both", False, "MOTOR_ENCODER_ERROR_2"
    LINK_ENCODER_ERROR = "measurement", False
    """What the link's encoder reads too far, rad."""
    LINK_ENCODER_CYCLES = "measurement", False, "LINK_ENCODER_ERROR"
    LINK_ENCODER_PHASE = "measurement", False, "LINK_ENCODER_ERROR"
    LINK_ENCODER_ERROR_2 = "measurement", False
    LINK_ENCODER_CYCLES_2 = "measurement", False, "LINK_ENCODER_ERROR_2"
    LINK_ENCODER_PHASE_2 = "measurement", False, "LINK_ENCODER_ERROR_2"
    # laws as tables: how many points there are, where they lie, and the torque at each
    _ignore_ = "_law _side _n"
    for _law, _side in (("FRICTION", "motor"), ("ANGLE", "motor"), ("SPRING", "spring")):
        vars()[f"{_law}_CURVE_POINTS"] = _side, False, f"{_law}_CURVE_TORQUE_1"
        for _n in range(1, 25):
            vars()[f"{_law}_CURVE_AT_{_n}"] = _side, False, f"{_law}_CURVE_TORQUE_{_n}"
            vars()[f"{_law}_CURVE_TORQUE_{_n}"] = _side, True

    @property
    def moves_link(self) -> bool:
        """Whether the link's motion depends on it: without a simulation its sensitivity would be wrong."""
        return self.side not in ("motor", "measurement")

    @property
    def shape_of(self) -> Term | None:
        """The term that it shapes; None for one that acts by itself."""
        return Term[self._of] if self._of else None


HARMONICS = ("", "_2", "_3", "_4", "_5")
"""Suffixes of the harmonics that a periodic term may have."""
RIPPLES, KINEMATIC_ERRORS, FRICTION_WAVES = (
    tuple((Term[f"{size}{n}"], Term[f"{cycles}{n}"], Term[f"{phase}{n}"]) for n in HARMONICS)
    for size, cycles, phase in (
        ("RIPPLE", "RIPPLE_CYCLES", "RIPPLE_PHASE"), ("KINEMATIC_ERROR", "KINEMATIC_CYCLES", "KINEMATIC_PHASE"),
        ("FRICTION_WAVE", "FRICTION_WAVE_CYCLES", "FRICTION_WAVE_PHASE"),
    )
)  # fmt: skip
"""Amplitude, cycles a turn and phase of each harmonic of the ripple, the transmission error and the dry friction."""
MOTOR_ENCODER_ERRORS, LINK_ENCODER_ERRORS = (
    tuple((Term[f"{side}_ERROR{n}"], Term[f"{side}_CYCLES{n}"], Term[f"{side}_PHASE{n}"]) for n in HARMONICS[:2])
    for side in ("MOTOR_ENCODER", "LINK_ENCODER")
)
"""The same of what each encoder reads too far."""

MOST_POINTS = 24
"""Of a law that is a table."""


@dataclass(frozen=True)
class Table:
    """The terms of a law that is a table: the number of its points, where they lie, and the torque at each."""

    points: Term
    at: tuple[Term, ...]
    torque: tuple[Term, ...]

    def of(self, terms: Floats) -> tuple[Floats, Floats]:
        """Where the points of a vector of terms lie (k,), and the torque at each (k,), N m; none of no law."""
        count = int(terms[self.points])
        return terms[list(self.at[:count])], terms[list(self.torque[:count])]


def _table(curve: str) -> Table:
    at, torque = ([Term[f"{curve}_{what}_{n + 1}"] for n in range(MOST_POINTS)] for what in ("AT", "TORQUE"))
    return Table(Term[f"{curve}_POINTS"], tuple(at), tuple(torque))


FRICTION_CURVE, ANGLE_CURVE, SPRING_CURVE = (_table(f"{law}_CURVE") for law in ("FRICTION", "ANGLE", "SPRING"))
"""Motor friction over velocity, rad/s; torque over the motor's angle and of the spring over its deflection, rad."""

GRAVITY = 9.81
"""Acceleration of gravity, m/s^2, that turns first moments (kg m) into torque."""

BASE_TERMS: dict[str, tuple[Term, float]] = {
    "Jm": (Term.MOTOR_INERTIA, 1.0),
    "K": (Term.STIFFNESS, 1.0),
    "JL": (Term.LINK_INERTIA, 1.0),
    "FVm": (Term.MOTOR_VISCOUS, 1.0),
    "FSm": (Term.MOTOR_COULOMB, 1.0),
    "FV": (Term.LINK_VISCOUS, 1.0),
    "FS": (Term.LINK_COULOMB, 1.0),
    "MX": (Term.GRAVITY_COS, GRAVITY),
    "MY": (Term.GRAVITY_SIN, GRAVITY),
    "offset": (Term.OFFSET, 1.0),
}
"""Base parameter to term and factor (eqs. 5 to 7)."""

RIGID_TERMS: dict[str, tuple[Term, float]] = {
    "J": (Term.MOTOR_INERTIA, 1.0),
    "FV": (Term.MOTOR_VISCOUS, 1.0),
    "FS": (Term.MOTOR_COULOMB, 1.0),
    "offset": (Term.OFFSET, 1.0),
    "MX": (Term.GRAVITY_COS, GRAVITY),
    "MY": (Term.GRAVITY_SIN, GRAVITY),
}

MEASUREMENT_TERMS: dict[str, tuple[Term, float]] = {
    "torque_delay": (Term.TORQUE_DELAY, 1.0),
    "torque_averaging": (Term.TORQUE_AVERAGING, 1.0),
    "link_skew": (Term.LINK_SKEW, 1.0),
    "link_zero": (Term.LINK_ZERO, 1.0),
    "link_scale": (Term.LINK_SCALE, 1.0),
    "link_drift": (Term.LINK_DRIFT, 1.0),
    "initial_deflection": (Term.INITIAL_DEFLECTION, 1.0),
    "initial_velocity": (Term.INITIAL_VELOCITY, 1.0),
    "reversal_speed": (Term.REVERSAL_SPEED, 1.0),
    "presliding": (Term.PRESLIDING, 1.0),
    "reversal_lead": (Term.REVERSAL_LEAD, 1.0),
    "effort_lag": (Term.EFFORT_LAG, 1.0),
    "link_turnover": (Term.LINK_TURNOVER, 1.0),
    "gravity_removed": (Term.GRAVITY_REMOVED, 1.0),
    "friction_removed": (Term.FRICTION_REMOVED, 1.0),
    "friction_removed_speed": (Term.FRICTION_REMOVED_SPEED, 1.0),
}
MEASUREMENT_KEYS = frozenset((*MEASUREMENT_TERMS, FAR_MODE))


def no_terms() -> Floats:
    """A vector (len(Term),) with every term switched off."""
    return np.zeros(len(Term))
