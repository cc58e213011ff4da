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
from flex_ident.parameters.keys import effect_in, key_parts, key_text
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import Candidate
from flex_ident.screening.sketching import effects_in


def objection_to(
    solver: SteadyFit, before: Fit, fit: Fit, candidate: Candidate, evidence: float, held: HeldOut,
    closable: tuple[float, float], own_error: float,
) -> str:  # fmt: skip
    """Why a candidate is not accepted; empty if nothing speaks against it. `closable`: excess before, share closed."""
    excess_before, share = closable
    if evidence < EVIDENCE:
        return (
            f"the likelihood gains too little for its parameters (BIC falls by {evidence:.0f}, {EVIDENCE:.0f} needed)"
        )
    if excess_before <= 0.0:
        return "what was left without it is no more than the noise"
    confirmed = held.share * (1.0 + excess_before) / excess_before
    needed = next((t for least, t in HELD_OUT_T if confirmed > least), math.inf)
    if held.t < needed:
        needed = min(needed, HELD_OUT_T[-1][1])
        return f"data left out of the fit do not confirm it (t = {held.t:.1f} over blocks, {needed} needed)"
    little = within_own_error(_changes(solver, before.values, fit.values), own_error)
    little = little or within_own_error(_own_changes(solver, fit, candidate), own_error)
    if little:
        return little
    rounded = within_rounding(_periodic_error(fit, candidate), position_noise(solver.problem))
    if rounded:
        return rounded
    vain = _noise_alone(solver, fit, candidate) or _within_filter(solver, fit, candidate)
    if vain:
        return vain
    rise = _torque_rms(solver, fit) / _torque_rms(solver, before) - 1.0
    if rise > 0.002:
        return f"the torque's gap grows by {100 * rise:.1f} % with it"
    bound = [k for k in candidate.keys if k in fit.at_bound and not parameter_named(k).angle]
    if bound:
        return f"{bound[0]} ends at the limit of what is physical ({fit.values[bound[0]]:.3g})"
    cycles = fit.values.get(candidate.cycles, math.inf) if effect_named(candidate.effect).whole_periods else math.inf
    if cycles * float(np.ptp(solver.problem.motion.position)) < LEAST_PERIODS * 2.0 * math.pi:
        return "it shows a part of one period only within the range of motion"
    weak = _weakest(solver, fit, candidate.scaled)
    if weak is not None:
        return f"{weak[0]} is known to {weak[1]:.1f} standard deviations only, {SIGNIFICANT:.0f} needed"
    essential = {key_text(candidate.effect, name) for name in effect_named(candidate.effect).essential}
    for key in (k for k in candidate.keys if k in essential):
        weak = _weakest(solver, fit, [key])
        if weak is not None:
            return f"without {key}, known to {weak[1]:.1f} standard deviations only, it is another effect"
    shape = [k for k in candidate.keys if k not in candidate.scaled and not parameter_named(k).angle]
    vague = _weakest(solver, fit, shape, SIGNIFICANT_SHAPE) if shape else None
    if vague is not None:
        return f"its shape is not determined: {vague[0]} is known to {vague[1]:.1f} standard deviations"
    times = [abs(fit.values[k]) for k in candidate.keys if parameter_named(k).unit == "s"]
    if min(times, default=math.inf) < solver.problem.recording.sample_time:
        what = "measurement, corrected for" if candidate.replaces else "the recording does not show what is in between"
        return f"{1e3 * min(times):.2f} ms is less than one sample: {what}"
    if share < SMALLEST_SHARE:
        return f"it closes {100 * share:.0f} % of the gap only, {100 * SMALLEST_SHARE:.0f} % needed for a cause"
    return ""


def within_own_error(changes: Mapping[str, float], own_error: float) -> str:
    """That an effect changes the prediction by less than the model without it may be wrong by; empty where it does not.

    `changes`: of torque and, with a link encoder, deflection, relative; `own_error`: of the torque, likewise.
    """
    errors = {"torque": own_error, "deflection": max(own_error, OWN_ERROR_OF_LINK)}
    if any(change >= errors[name] for name, change in changes.items()):
        return ""
    return "; ".join(
        f"it changes the {name} by {100 * change:.2f} % only, where the model without it may be wrong by "
        f"{100 * errors[name]:.2f} %"
        for name, change in changes.items()
    )


def _periodic_error(fit: Fit, candidate: Candidate) -> float:
    """The largest amplitude of a periodic error of the motor's position, rad; 0 of what is none."""
    sizes = [abs(fit.values[k]) for k in candidate.scaled if parameter_named(k).unit == "rad"]
    return max(sizes, default=0.0) if candidate.cycles and not effect_named(candidate.effect).needs_link else 0.0


def within_rounding(amplitude: float, noise: float) -> str:
    """That a periodic error of a position, rad, is no larger than its encoder's rounding and `noise`, rms; else empty.

    Rounding is an error over the position as well, and the motor's inertia and the resonance carry both to the torque.
    """
    if not 0.0 < amplitude <= math.sqrt(2.0) * noise:
        return ""
    return f"{amplitude:.2g} rad is no more than the encoder's rounding and noise ({noise:.2g} rad rms)"


def _noise_alone(solver: SteadyFit, fit: Fit, candidate: Candidate) -> str:
    """That what it takes off the recorded torque may be its noise; empty where it is more."""
    effect, recording = effect_named(candidate.effect), solver.problem.recording
    if effect.of_noise is None:
        return ""
    own = {key_parts(k)[1]: fit.values[k] for k in candidate.keys}
    return effect.of_noise(own, recording.motor_torque, torque_noise(solver.problem))


def _within_filter(solver: SteadyFit, fit: Fit, candidate: Candidate) -> str:
    """That the way over which a law of the motor acts is no longer than what the low-pass changes at reversals."""
    if effect_named(candidate.effect).where != "motor":
        return ""
    known = ((k, parameter_named(k)) for k in candidate.keys)
    ways = [abs(fit.values[k]) for k, p in known if p.unit == "rad" and not p.angle and not p.fixed]
    error = error_at_reversals(solver.problem)
    if min(ways, default=math.inf) > OVER_FILTER * error:
        return ""
    return f"{min(ways):.2g} rad is within what the low-pass changes of the position at reversals ({error:.2g} rad rms)"


def own_error_of(solver: SteadyFit, accepted: Sequence[tuple[str, Fit, Fit]]) -> float:
    """Change of the prediction, relative, that method and laws may make: effects with the fits before and after."""
    laws = [
        effect_named(name).law_error * max(_changes(solver, before.values, after.values).values())
        for name, before, after in accepted
    ]
    return max(OWN_ERROR, math.hypot(*laws))


def _changes(solver: SteadyFit, before: Values, after: Values) -> dict[str, float]:
    """By how much the predicted torque and, with a link encoder, the predicted deflection change, each relative.

    Where the motor sticks nothing counts: friction is what no model can know there.
    """
    problem, rows = solver.problem, counted(solver.problem, solver.problem.usable)
    sizes = {"torque": float(np.std(problem.torque[rows]))}
    if problem.link is not None:
        sizes["deflection"] = float(np.std((problem.motion.position[:: problem.decimation] - problem.link)[rows]))
    one, two = problem.residuals(before), problem.residuals(after)
    return {
        name: float(np.std((b - a)[rows])) / size for (name, size), a, b in zip(sizes.items(), one, two, strict=True)
    }


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
