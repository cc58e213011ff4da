"""What the recorded effort is, told from the fit: the motor's torque, the torque through the gear, less gravity."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flex_ident.effects import key_named
from flex_ident.errors import ExcitationError
from flex_ident.estimation.gravity_kind import gravity_compensated
from flex_ident.estimation.gravity_profile import with_gravity_walked
from flex_ident.estimation.hidden_gravity import with_hidden_gravity
from flex_ident.estimation.kind_fit import ROUNDS, KindFit, refitted
from flex_ident.estimation.kind_gain import gain_of
from flex_ident.estimation.kind_priors import friction_keys, friction_priors
from flex_ident.estimation.thresholds import (
    AS_LIKELY,
    CLEARLY,
    FAR,
    HARDLY_ANY,
    MOST_WITH_LINK,
    NO_FRICTION,
    NO_INERTIA,
    NO_TORQUE,
    SEEN,
)  # fmt: skip
from flex_ident.likelihood.covariance import Uncertainty, uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.remainder import remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Code, Notice
from flex_ident.parameters import UNITS
from flex_ident.parameters.effort_kinds import (
    FRICTION_COMPENSATED,
    FRICTION_KEYS,
    GRAVITY_COMPENSATED,
    GRAVITY_REMOVED,
    JOINT_SENSOR,
    MOTOR,
    MOTOR_KEYS,
)  # fmt: skip


def resolved(problem: FitProblem, solver: SteadyFit, fit: Fit, kind: str) -> KindFit:
    """The fit of a base model under the kind of effort asked for, or under the one that `auto` finds. Raises nothing
    that the fit has not raised already."""
    sensor = not problem.rigid and "Jm" not in fit.free
    if kind == JOINT_SENSOR or sensor:
        case = {"case": "found" if kind == "auto" else "given"}
        said = Notice(Code.EFFORT_JOINT_SENSOR, "motor_torque", {"inertia_percent": 0.0}, case)
        sensed = KindFit(JOINT_SENSOR, solver, fit, (said,))
        return with_hidden_gravity(sensed) if kind == "auto" and not _holds_gravity(problem) else sensed
    if kind == GRAVITY_COMPENSATED:
        said = Notice(Code.EFFORT_GRAVITY_COMPENSATED, "motor_torque", {}, {"case": "given"})
        return with_gravity_walked(problem, KindFit(GRAVITY_COMPENSATED, solver, fit, (said,)))
    if kind == FRICTION_COMPENSATED:
        texts = {"case": "given", "absent": " and ".join(friction_keys(rigid=problem.rigid))}
        own = KindFit(FRICTION_COMPENSATED, solver, fit, (Notice(Code.EFFORT_FRICTION_COMPENSATED, texts=texts),))
        return own if problem.rigid or _holds_gravity(problem) else with_hidden_gravity(own)
    if problem.rigid or kind != "auto" or any(key_named(k).effect for k in fit.free):
        return KindFit(MOTOR, solver, fit)
    found = _found(problem, solver, fit)
    anew = (
        _fitted_anew(problem, solver, fit, found) if found.kind in (GRAVITY_COMPENSATED, FRICTION_COMPENSATED) else None
    )
    found = found if anew is None else _found(problem, *anew)
    return replace(found, frictionless=found.kind == MOTOR and hardly_rubs(problem, found.fit))


def _found(problem: FitProblem, solver: SteadyFit, fit: Fit) -> KindFit:
    """The kind of effort that speaks for itself, against a fit with the motor's torque."""
    try:
        found = _joint_sensor(problem, solver, fit) or _friction_compensated(problem, solver, fit)
        if _holds_gravity(problem):
            return found or KindFit(MOTOR, solver, fit)
        found = found or gravity_compensated(problem, solver, fit)
        return with_hidden_gravity(found) if found.kind != GRAVITY_COMPENSATED else found
    except ExcitationError:  # the other kind's model runs away: it is not this one
        return KindFit(MOTOR, solver, fit)


def _fitted_anew(problem: FitProblem, solver: SteadyFit, fit: Fit, found: KindFit) -> tuple[SteadyFit, Fit] | None:
    """The fit with the motor's torque from where another kind's ended, where it is the better for that; else None.

    A fit that has stalled loses against all that begins elsewhere, whatever the effort is.
    """
    values = found.fit.values.without((GRAVITY_REMOVED,))
    values = values | {k: max(0.0, values[k]) for k in FRICTION_KEYS if k in values}
    try:
        own, again = refitted(problem, solver, [k for k in fit.free if k in UNITS], values, rough=True)
    except ExcitationError:
        return None
    return (own, again) if gain_of(problem, own, fit, again).size > CLEARLY else None


def _holds_gravity(problem: FitProblem) -> bool:
    """Whether the weight that the robot's description gives was found in the effort."""
    return any(n.code is Code.URDF_GRAVITY and n.case == "held" for n in problem.recording.notices)


def _drives(problem: FitProblem, fit: Fit, known: Uncertainty) -> bool:
    """Whether the motor's friction drives it on the whole, at its rms speed: none does, whatever its law."""
    speeds = np.array([_rms_speed(problem), 1.0])
    rows = [fit.free.index(key) for key in FRICTION_KEYS]
    std = math.sqrt(float(speeds @ known.covariance[np.ix_(rows, rows)] @ speeds))
    return float(speeds @ fit.values.vector(FRICTION_KEYS)) < -SEEN * std


def hardly_rubs(problem: FitProblem, fit: Fit) -> bool:
    """Whether the motor's side rubs less than the link's at its rms speed: seals, bearings and a gear's first stage are
    on the motor's side and reflected, so that a controller that adds what friction takes is as likely as none."""
    if not all(key in fit.values for key in (*FRICTION_KEYS, "FV", "FS")):
        return False
    speed, values, known = _rms_speed(problem), fit.values, uncertainty_of(fit, problem.rate_hz)
    seen = any(key in fit.free and values[key] > SEEN * known.std(key) for key in ("FV", "FS"))
    return seen and values["FVm"] * speed + values["FSm"] < values["FV"] * speed + values["FS"]


def _rms_speed(problem: FitProblem) -> float:
    return float(np.std(problem.motion.velocity))


def _joint_sensor(problem: FitProblem, solver: SteadyFit, fit: Fit) -> KindFit | None:
    """The fit without the motor's side, where that is negligible and nothing is lost; else None."""
    values, known = fit.values, uncertainty_of(fit, problem.rate_hz)
    std = {k: min(known.std(k), 1e300) if k not in fit.at_bound else 0.0 for k in MOTOR_KEYS}
    inertia = values["Jm"] + 2.0 * std["Jm"]
    if inertia > NO_INERTIA * values["JL"]:
        return None
    speed = _rms_speed(problem)
    torque = float(np.std(problem.torque[problem.usable]))
    link = values.get("FV", 0.0) * speed + values.get("FS", 0.0)
    if values.get("FVm", 0.0) * speed + values.get("FSm", 0.0) > max(NO_FRICTION * link, NO_TORQUE * torque):
        return None
    keys = [k for k in fit.free if k in UNITS and k not in MOTOR_KEYS]
    own, found = refitted(problem, solver, keys, values.without(MOTOR_KEYS))
    # A motor that turns without any inertia is none, whatever little else its side explains.
    may_cost = FAR if inertia < HARDLY_ANY * values["JL"] else AS_LIKELY
    if gain_of(problem, own, fit, found).size < -may_cost:
        return None
    sizes = {"inertia_percent": 100.0 * inertia / values["JL"]}
    notice = Notice(Code.EFFORT_JOINT_SENSOR, "motor_torque", sizes, {"case": "found"})
    return KindFit(JOINT_SENSOR, own, found, (notice,))


def _friction_compensated(problem: FitProblem, solver: SteadyFit, fit: Fit) -> KindFit | None:
    """The fit with friction of either sign, where what is left of the motor's is negative and that explains all."""
    if not set(FRICTION_KEYS) & set(fit.at_bound):
        return None
    keys = [k for k in fit.free if k in UNITS and k not in FRICTION_KEYS]
    own = SteadyFit(problem, priors={**solver.priors, **friction_priors(problem)}, marks=solver.marks, local=True)
    found: Fit | None = None
    values = fit.values
    for iterations, tolerance in ROUNDS:
        found = own.solve(
            (*keys, *own.priors), values, own.whitenings(values), iterations=iterations, tolerance=tolerance
        )
        values = found.values
    assert found is not None
    gain, known, left = gain_of(problem, own, fit, found), uncertainty_of(found, problem.rate_hz), remainder(own, found)
    negative = any(found.values[k] < -SEEN * known.std(k) for k in FRICTION_KEYS)
    explains = left.evidence != "none" and not left.structured(left.gap)
    drives = gain.share > MOST_WITH_LINK and _drives(problem, found, known)
    if gain.size < CLEARLY or not (drives or (negative and explains)):
        return None
    notice = Notice(Code.EFFORT_FRICTION_COMPENSATED, "motor_torque", {"gain": gain.size}, {"case": "found"})
    return KindFit(FRICTION_COMPENSATED, own, found, (notice,))
