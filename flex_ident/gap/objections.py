"""What speaks against accepting a candidate that was refitted together with the whole model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from flex_ident.effects import effect_named, parameter_named
from flex_ident.errors import ExcitationError
from flex_ident.gap.thresholds import (
    EVIDENCE,
    HELD_OUT_T,
    LEAST_PERIODS,
    OVER_FILTER,
    OWN_ERROR,
    SIGNIFICANT,
    SIGNIFICANT_SHAPE,
    SMALLEST_SHARE,
)
from flex_ident.likelihood.comparison import HeldOut
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.noise import error_at_reversals, position_noise, torque_noise
from flex_ident.likelihood.remainder import counted
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.likelihood.thresholds import OWN_ERROR_OF_LINK
from flex_ident.notices import Reason, Why
from flex_ident.parameters.keys import effect_in, key_parts, key_text
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import Candidate
from flex_ident.screening.sketching import effects_in


def objection_to(
    solver: SteadyFit, before: Fit, fit: Fit, candidate: Candidate, evidence: float, held: HeldOut,
    closable: tuple[float, float], own_error: float,
) -> Reason | None:  # fmt: skip
    """Why a candidate is not accepted; None if nothing speaks against it. `closable`: excess before, share closed."""
    excess_before, share = closable
    if evidence < EVIDENCE:
        return Reason(Why.LITTLE_LIKELIHOOD, numbers={"fall": evidence, "needed": EVIDENCE})
    if excess_before <= 0.0:
        return Reason(Why.WITHIN_NOISE)
    confirmed = held.share * (1.0 + excess_before) / excess_before
    needed = next((t for least, t in HELD_OUT_T if confirmed > least), math.inf)
    if held.t < needed:
        needed = min(needed, HELD_OUT_T[-1][1])
        return Reason(Why.NOT_CONFIRMED, numbers={"t": held.t, "needed": needed})
    little = within_own_error(_changes(solver, before.values, fit.values), own_error)
    little = little or within_own_error(_own_changes(solver, fit, candidate), own_error)
    if little is not None:
        return little
    rounded = within_rounding(_periodic_error(fit, candidate), position_noise(solver.problem))
    if rounded is not None:
        return rounded
    vain = _noise_alone(solver, fit, candidate) or _within_filter(solver, fit, candidate)
    if vain is not None:
        return vain
    rise = _torque_rms(solver, fit) / _torque_rms(solver, before) - 1.0
    if rise > 0.002:
        return Reason(Why.TORQUE_GAP_GROWS, numbers={"percent": 100.0 * rise})
    bound = [k for k in candidate.keys if k in fit.at_bound and not parameter_named(k).angle]
    if bound:
        return Reason(Why.AT_BOUND, bound[0], {"value": fit.values[bound[0]]})
    cycles = fit.values.get(candidate.cycles, math.inf) if effect_named(candidate.effect).whole_periods else math.inf
    if cycles * float(np.ptp(solver.problem.motion.position)) < LEAST_PERIODS * 2.0 * math.pi:
        return Reason(Why.PART_OF_A_PERIOD)
    weak = _weakest(solver, fit, candidate.scaled)
    if weak is not None:
        return Reason(Why.NOT_SIGNIFICANT, weak[0], {"stds": weak[1], "needed": SIGNIFICANT})
    essential = {key_text(candidate.effect, name) for name in effect_named(candidate.effect).essential}
    for key in (k for k in candidate.keys if k in essential):
        weak = _weakest(solver, fit, [key])
        if weak is not None:
            return Reason(Why.OTHER_WITHOUT, key, {"stds": weak[1]})
    shape = [k for k in candidate.keys if k not in candidate.scaled and not parameter_named(k).angle]
    vague = _weakest(solver, fit, shape, SIGNIFICANT_SHAPE) if shape else None
    if vague is not None:
        return Reason(Why.SHAPE_OPEN, vague[0], {"stds": vague[1]})
    times = [abs(fit.values[k]) for k in candidate.keys if parameter_named(k).unit == "s"]
    if min(times, default=math.inf) < solver.problem.recording.sample_time:
        case = "measurement" if candidate.replaces else "between"
        return Reason(Why.BELOW_A_SAMPLE, numbers={"time_ms": 1e3 * min(times)}, case=case)
    if share < SMALLEST_SHARE:
        closed = {"percent": 100.0 * share, "needed_percent": 100.0 * SMALLEST_SHARE}
        return Reason(Why.CLOSES_LITTLE, numbers=closed, case="cause")
    return None


def within_own_error(changes: Mapping[str, float], own_error: float) -> Reason | None:
    """That an effect changes the prediction by less than the model without it may be wrong by; None where it does not.

    `changes`: of torque and, with a link encoder, deflection, relative; `own_error`: of the torque, likewise.
    """
    errors = {"torque": own_error, "deflection": max(own_error, OWN_ERROR_OF_LINK)}
    if any(change >= errors[name] for name, change in changes.items()):
        return None
    by = {f"{name}_percent": 100.0 * change for name, change in changes.items()}
    wrong = {f"{name}_wrong_percent": 100.0 * errors[name] for name in changes}
    return Reason(Why.WITHIN_OWN_ERROR, numbers={**by, **wrong})


def _periodic_error(fit: Fit, candidate: Candidate) -> float:
    """The largest amplitude of a periodic error of the motor's position, rad; 0 of what is none."""
    sizes = [abs(fit.values[k]) for k in candidate.scaled if parameter_named(k).unit == "rad"]
    return max(sizes, default=0.0) if candidate.cycles and not effect_named(candidate.effect).needs_link else 0.0


def within_rounding(amplitude: float, noise: float) -> Reason | None:
    """That a periodic error of a position, rad, is no larger than its encoder's rounding and `noise`, rms; else None.

    Rounding is an error over the position as well, and the motor's inertia and the resonance carry both to the torque.
    """
    if not 0.0 < amplitude <= math.sqrt(2.0) * noise:
        return None
    return Reason(Why.WITHIN_ROUNDING, numbers={"amplitude": amplitude, "noise": noise})


def _noise_alone(solver: SteadyFit, fit: Fit, candidate: Candidate) -> Reason | None:
    """That what it takes off the recorded torque may be its noise; None where it is more."""
    effect, recording = effect_named(candidate.effect), solver.problem.recording
    if effect.of_noise is None:
        return None
    own = {key_parts(k)[1]: fit.values[k] for k in candidate.keys}
    return effect.of_noise(own, recording.motor_torque, torque_noise(solver.problem))


def _within_filter(solver: SteadyFit, fit: Fit, candidate: Candidate) -> Reason | None:
    """That the way over which a law of the motor acts is no longer than what the low-pass changes at reversals."""
    if effect_named(candidate.effect).where != "motor":
        return None
    known = ((k, parameter_named(k)) for k in candidate.keys)
    ways = [abs(fit.values[k]) for k, p in known if p.unit == "rad" and not p.angle and not p.fixed]
    error = error_at_reversals(solver.problem)
    if min(ways, default=math.inf) > OVER_FILTER * error:
        return None
    return Reason(Why.WITHIN_FILTER, numbers={"way": min(ways), "error": error})


def own_error_of(solver: SteadyFit, accepted: Sequence[tuple[str, Fit, Fit]]) -> float:
    """Change of the prediction, relative, that method and laws may make: effects with the fits before and after."""
    laws = [
        effect_named(name).law_error * max(_changes(solver, before.values, after.values).values())
        for name, before, after in accepted
    ]
    return max(OWN_ERROR, math.hypot(*laws))


def _changes(solver: SteadyFit, before: Values, after: Values) -> dict[str, float]:
    """By how much the predicted torque and, with a link encoder, the predicted deflection change, each relative.

    Where the motor sticks nothing counts: friction is what no model can know there. A constant counts in the torque,
    where it is an effect, and not in the deflection, where it is the encoders' zero.
    """
    problem, rows = solver.problem, counted(solver.problem, solver.problem.usable)
    sizes = {"torque": float(np.std(problem.torque[rows]))}
    if problem.link is not None:
        sizes["deflection"] = float(np.std((problem.motion.position[:: problem.decimation] - problem.link)[rows]))
    one, two = problem.residuals(before), problem.residuals(after)
    changes = {name: (b - a)[rows] for name, a, b in zip(sizes, one, two, strict=True)}
    sized = {"torque": float(np.sqrt(np.mean(changes["torque"] ** 2)))}
    if "deflection" in changes:
        sized["deflection"] = float(np.std(changes["deflection"]))
    return {name: size / sizes[name] for name, size in sized.items()}


def _own_changes(solver: SteadyFit, fit: Fit, candidate: Candidate) -> dict[str, float]:
    """What the candidate changes by itself, all else held: one that does little may only have led the fit out of a
    minimum. Infinitely much where the model runs away without it."""
    alone = values_with(fit.values, [k for k in fit.free if k not in candidate.keys])
    try:
        changes = _changes(solver, alone, fit.values)
    except ExcitationError:
        return {"torque": math.inf}
    return {name: change if math.isfinite(change) else math.inf for name, change in changes.items()}


def _torque_rms(solver: SteadyFit, fit: Fit) -> float:
    residual = solver.problem.residuals(fit.values)[0][solver.problem.usable]
    return float(np.sqrt(np.mean(residual**2)))


def _weakest(solver: SteadyFit, fit: Fit, keys: Sequence[str], least: float = SIGNIFICANT) -> tuple[str, float] | None:
    """The best-known of the keys with its ratio to its standard deviation, when even that is less than `least`."""
    uncertainty = uncertainty_of(fit, solver.problem.rate_hz)
    ratios = []
    for key in keys:
        std = uncertainty.std(key)
        ratios.append((key, abs(fit.values[key]) / std if std > 0 and np.isfinite(std) else 0.0))
    best = max(ratios, key=lambda item: item[1])
    return best if best[1] < least else None


def values_with(values: Values, keys: Sequence[str]) -> Values:
    """The values of the base, of the effects' `keys`, and where the points of their curves lie."""
    there = effects_in(keys)
    return values.only([k for k in values if k in keys or effect_in(k) is None or _fixed_in(k, there)])


def _fixed_in(key: str, effects: Sequence[str]) -> bool:
    return effect_in(key) in effects and parameter_named(key).fixed
