"""Kinds of effort by name: which are known, which are built, and what each leaves out of the model."""

from __future__ import annotations

from typing import Literal

from flex_ident.errors import UsageError

EffortKind = Literal["motor", "joint_sensor", "gravity_compensated", "friction_compensated", "current", "command"]
MOTOR: EffortKind = "motor"
JOINT_SENSOR: EffortKind = "joint_sensor"
GRAVITY_COMPENSATED: EffortKind = "gravity_compensated"
FRICTION_COMPENSATED: EffortKind = "friction_compensated"
CURRENT: EffortKind = "current"
COMMAND: EffortKind = "command"
USABLE = ("auto", MOTOR, JOINT_SENSOR, GRAVITY_COMPENSATED, FRICTION_COMPENSATED, CURRENT, COMMAND)
UNSIGNED = "unsigned"
EFFORT_KINDS = (*USABLE, UNSIGNED)
MOTOR_KEYS = ("Jm", "FVm", "FSm")
"""What a sensor behind the gear does not see."""
REVERSAL_KEYS = ("reversal_speed", "presliding", "reversal_lead")
"""How the motor's dry friction turns over: nothing, where there is none."""
FRICTION_KEYS = ("FVm", "FSm")
RIGID_FRICTION_KEYS = ("FV", "FS")
"""The motor's friction: where the controller adds it, what its model is off by is left, of either sign."""
GRAVITY_REMOVED = "gravity_removed"
"""Measurement key: the share of gravity that the controller adds, and the effort is without."""
FRICTION_REMOVED, FRICTION_REMOVED_SPEED = "friction_removed", "friction_removed_speed"
"""Measurement keys: the dry friction that the controller adds and the effort is without, and the speed at which that
turns over, where the motor's own does so at once."""
REMOVED_KEYS = (GRAVITY_REMOVED, FRICTION_REMOVED, FRICTION_REMOVED_SPEED)
"""What a controller adds, by kind of effort; part of the model, and no key of the joint."""


def check_effort_kind(kind: str, *, method: str = "auto") -> None:
    """Raises UsageError, in one line, for a kind of effort that is none, or cannot be used."""
    if kind not in EFFORT_KINDS:
        raise UsageError(f"effort kind is '{kind}': expected one of {', '.join(EFFORT_KINDS)}.")
    if kind == UNSIGNED:
        raise UsageError(
            "effort kind unsigned: an absolute value does not tell inertia from friction: record the effort with its "
            "sign, or name the signal that has it with --effort."
        )
    if kind in (JOINT_SENSOR, GRAVITY_COMPENSATED, FRICTION_COMPENSATED) and method != "auto":
        raise UsageError(
            f"effort kind {kind} needs --method auto: the equations of {method} are of the motor's torque."
        )
