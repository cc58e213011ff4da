"""One parameter of an estimate with all of its uncertainty, and the modes that the values make."""

from __future__ import annotations

import math

import numpy as np

from flex_ident.effects import CATALOGUE, key_named, told_key, trade_error
from flex_ident.estimation.estimate import Estimate
from flex_ident.estimation.evidence import is_identifiable
from flex_ident.estimation.thresholds import (
    CANCELLED,
    DRY_REVERSAL_ERROR,
    FOLDING,
    LINK_REVERSAL_ERROR,
    LINK_REVERSAL_SEEN,
    REVERSAL_ERROR,
)
from flex_ident.estimation.unseen_effects import loss_error
from flex_ident.likelihood.fit import key_bounds
from flex_ident.parameters import Parameter
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import MEASUREMENT_KEYS

CANCELLING = ("torque_delay", "effort_lag")


def modes_hz(values: Values) -> dict[str, float]:
    """Locked-motor and free resonance, Hz, of Jm, K and JL; without Jm the first only."""
    k, jm, jl = values["K"], values.get("Jm", 0.0), values["JL"]
    modes = {"locked_motor_hz": math.sqrt(k / jl) / (2.0 * math.pi)}
    if jm > 0.0:
        modes = {"free_resonance_hz": math.sqrt(k * (1.0 / jm + 1.0 / jl)) / (2.0 * math.pi), **modes}
    return modes


def folding_error(estimate: Estimate) -> float:
    """Relative standard deviation for what the recording's rate folds back onto the locked-motor frequency.

    A held command excites its images about the rate, and an inertia answers each with the inverse square of its
    frequency: the image is (f / (rate - f))^3 of the motion. It matters most where the motor hardly moves.
    """
    if estimate.problem.rigid:
        return 0.0
    locked_hz, rate_hz = modes_hz(estimate.fit.values)["locked_motor_hz"], estimate.problem.recording.sample_rate_hz
    nearest_hz = max(rate_hz - locked_hz, 0.5 * rate_hz)
    return FOLDING * (locked_hz / nearest_hz) ** 3


def reversal_error(estimate: Estimate, key: str) -> float:
    """Standard deviation of the friction of motor and link for what the laws of its turning over leave open.

    And of the motor's inertia: friction that turns over otherwise looks like it, by its size over the acceleration, and
    half of that where no structure is left.
    """
    values, problem = estimate.fit.values, estimate.problem
    if key in ("FV", "FS") and not problem.rigid:
        link = problem.link_response_of(values)
        share = LINK_REVERSAL_ERROR if problem.link is None else LINK_REVERSAL_SEEN
        error = share * values.get("FS", 0.0)
        return error if key == "FS" or link is None else error / (float(np.std(link.velocity)) or math.inf)
    dry = "FS" if problem.rigid else "FSm"
    if key == dry:
        return DRY_REVERSAL_ERROR * values.get(dry, 0.0)
    error = REVERSAL_ERROR * values.get(dry, 0.0)
    speed, acceleration = (float(np.std(x)) or math.inf for x in (problem.motion.velocity, problem.motion.acceleration))
    if key == ("FV" if problem.rigid else "FVm"):
        return error / speed
    if key == ("J" if problem.rigid else "Jm"):
        return (1.0 if estimate.left.structured(estimate.left.gap) else 0.5) * error / acceleration
    return 0.0


def cancelled_error(estimate: Estimate, key: str) -> float:
    """What the standard deviation of a low-pass, s, that an equal delay of the other sign cancels lacks, and of that
    delay.

    Only the square of the low-pass's time is left in the torque: relative to its size it is known half as well as the
    slope there tells.
    """
    delay, lag = (estimate.fit.values.get(k, 0.0) for k in CANCELLING)
    if key not in CANCELLING or lag <= 0.0 or abs(delay + lag) > CANCELLED * lag:
        return 0.0
    std = estimate.uncertainty.std("effort_lag")
    return math.sqrt(3.0) * std if math.isfinite(std) else 0.0


def forces_open(estimate: Estimate) -> float:
    """Relative standard deviation of all forces for what effects of the model leave open of their scale."""
    duration_s = float(np.ptp(estimate.problem.recording.time))
    held = estimate.fit.values.effects.items()
    return math.hypot(*(e.forces_open(v, duration_s) for n, v in held if (e := CATALOGUE[n]).forces_open is not None))


def beside_its_like(estimate: Estimate) -> bool:
    """Whether a model holds an effect that another of the same kind may be beside: then the intervals hold that one."""
    held = (CATALOGUE[name] for name in estimate.fit.values.effects)
    return any(effect.unseen is not None and effect.where == "link" for effect in held)


def identified_parameter(estimate: Estimate, key: str) -> Parameter:
    """One key of an estimate with its uncertainty and whether the data determine it."""
    value = float(estimate.fit.values[key])
    std = estimate.uncertainty.std(key)
    if key not in MEASUREMENT_KEYS:
        std = math.hypot(std, folding_error(estimate) * value)
    if key_named(key).is_force:
        std = math.hypot(std, forces_open(estimate) * value)
    beside = estimate.unseen.get(key, 0.0) if beside_its_like(estimate) else 0.0
    loss = loss_error(key, estimate.fit.values, estimate.lossy)
    std = math.hypot(
        std, trade_error(key, estimate.fit.values), reversal_error(estimate, key), beside, loss,
        cancelled_error(estimate, key),
    )  # fmt: skip
    at_bound = key in estimate.fit.at_bound
    ci95 = None
    if at_bound:
        low, high = key_bounds(key, {})
        ci95 = (value, value + 1.96 * std) if value - low <= high - value else (value - 1.96 * std, value)
    # A point of a curve may be nothing; its band says how well it is known.
    always = key in MEASUREMENT_KEYS or told_key(key) != key
    identifiable = True if always else is_identifiable(estimate, key)
    return Parameter(key, value, std, key_named(key).unit, identifiable, ci95=ci95, at_bound=at_bound)
