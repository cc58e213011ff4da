"""What is estimated beside the joint under each kind of effort, and what is said of a kind that is told."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from flex_ident.effects import key_named
from flex_ident.estimation.thresholds import STEEL, WIDEST_M
from flex_ident.likelihood.fit import Prior
from flex_ident.likelihood.nuisances import LATE_SAMPLES, model_priors
from flex_ident.likelihood.problem import FitProblem
from flex_ident.notices import Code, Notice
from flex_ident.parameters.current import is_current
from flex_ident.parameters.effort_kinds import (
    COMMAND,
    CURRENT,
    FRICTION_COMPENSATED,
    FRICTION_KEYS,
    FRICTION_REMOVED,
    FRICTION_REMOVED_SPEED,
    GRAVITY_COMPENSATED,
    GRAVITY_REMOVED,
    MOTOR,
    REVERSAL_KEYS,
    RIGID_FRICTION_KEYS,
)
from flex_ident.parameters.keys import effect_in
from flex_ident.recording import Recording
from flex_ident.screening.sketching import effects_in

REMOVED, MOST_OFF = 0.1, 1.0
"""Share of the gravity that a controller adds by which its model is off, one standard deviation and at most. Set by
hand: masses by a manufacturer are known to some per cent, a tool that nobody entered weighs some more."""
SMOOTH, FIRST_ADDED = 0.1, 0.1
"""Speed at which a controller's dry friction turns over, over the rms speed, one standard deviation; and where its
size starts, over the rms torque. Set by hand."""


def friction_keys(*, rigid: bool) -> tuple[str, ...]:
    """The motor's friction, which is not in the effort where the controller adds it."""
    return RIGID_FRICTION_KEYS if rigid else FRICTION_KEYS


def friction_priors(problem: FitProblem) -> dict[str, Prior]:
    """What may be left of the motor's friction where the controller adds it: of either sign, no larger than torque; and
    how the controller's turns over, smoothly, at a speed that is not the motor's."""
    torque, speed = float(np.std(problem.torque)), float(np.std(problem.motion.velocity)) or 1.0
    sizes = zip(friction_keys(rigid=problem.rigid), (torque / speed, torque), strict=True)
    left = {key: Prior(0.0, size, -math.inf, math.inf) for key, size in sizes}
    added = Prior(0.0, torque, 0.0, math.inf, start=FIRST_ADDED * torque)
    smooth = Prior(0.0, SMOOTH * speed, 1e-3 * SMOOTH * speed, speed, start=0.3 * SMOOTH * speed)
    return {**left, FRICTION_REMOVED: added, FRICTION_REMOVED_SPEED: smooth}


def removed_prior() -> Prior:
    """The share of gravity that a controller takes off the effort."""
    return Prior(1.0, REMOVED, 1.0 - MOST_OFF, 1.0 + MOST_OFF, start=1.0)


def largest_moment(inertia: float) -> float:
    """The largest first moment, kg m, that a body can have whose inertia about the joint is that, kg m^2.

    A cylinder of mass m at distance l, its axis along the joint's, has the inertia m l^2 + m^2 / (2 pi rho h); the
    product m l is largest where the second part is a third of the whole.
    """
    mass = math.sqrt(2.0 * math.pi * STEEL * WIDEST_M * inertia / 3.0)
    return math.sqrt(2.0 / 3.0 * inertia * mass)


def base_priors(
    problem: FitProblem, keys: Sequence[str], kind: str = MOTOR, *, late_samples: float = LATE_SAMPLES
) -> dict[str, Prior]:
    """What is estimated beside the base `keys` under a kind of effort, with what is known of it beforehand."""
    priors = kept_priors(model_priors(problem, effects_in(keys), late_samples=late_samples), keys)
    if kind == GRAVITY_COMPENSATED and not problem.rigid:
        priors[GRAVITY_REMOVED] = removed_prior()
    return {**priors, **friction_priors(problem)} if kind == FRICTION_COMPENSATED else priors


def as_told(recording: Recording, kind: str) -> tuple[Recording, str]:
    """The recording with what is said of its effort's unit, and the kind that the fit is of.

    A current, by its name or as it is told, has no SI unit to miss, and is fitted as a torque of unknown scale.
    """
    named = is_current(recording.notices)
    if kind == CURRENT or (kind == "auto" and named):
        kept = tuple(n for n in recording.notices if n.code is not Code.EFFORT_NOT_SI)
        if not named:
            kept = (*kept, Notice(Code.EFFORT_CURRENT, "motor_torque", texts={"case": "given"}))
        return replace(recording, notices=kept), MOTOR
    if kind == COMMAND:
        said = Notice(Code.EFFORT_COMMANDED, "motor_torque")
        return replace(recording, notices=(*recording.notices, said)), MOTOR
    return recording, kind


def kept_priors(priors: Mapping[str, Prior], keys: Sequence[str]) -> dict[str, Prior]:
    """The nuisances that the keys leave something to do: without the motor's dry friction none turns over."""
    dry = {"FSm", "FS"} if "J" in keys else {"FSm"}
    has_friction = bool(dry & set(keys)) or any(key_named(k).effect for k in keys)
    kept = {k: p for k, p in priors.items() if has_friction or k not in REVERSAL_KEYS}
    return {k: p for k, p in kept.items() if effect_in(k) is None or k in keys}
