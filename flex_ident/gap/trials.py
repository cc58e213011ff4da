"""A candidate refitted together with the whole model, and what speaks for and against accepting it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.effects import CATALOGUE, effect_named, key_named, parameter_named
from flex_ident.errors import ExcitationError
from flex_ident.estimation.covariance import uncertainty_of
from flex_ident.estimation.fit import Fit, key_bounds
from flex_ident.gap.candidates import Candidate
from flex_ident.gap.fitting import (
    GapFit,
    HeldOut,
    correlation_factor,
    gap_priors,
    held_out_comparison,
    log_likelihood_gain,
)
from flex_ident.gap.screening import Score
from flex_ident.parameters.keys import effect_in, key_text

EVIDENCE = 10.0
"""Fall of the Bayesian information criterion from which a candidate counts (Kass and Raftery: very strong)."""
HELD_OUT_T = ((0.8, 1.1), (0.5, 1.8), (0.0, 2.5))
"""By the share of the closable cost on left-out data that is saved, the t over blocks that is needed: what saves most
of it may lie all in a resonance or where the torque saturates, but not in one block."""
LEAST_PERIODS = 0.9
"""Of what is periodic in the motor's angle, within the range of motion: a part of a period is gravity or a spring."""
SMALLEST_SHARE = 0.2
"""Share of the closable gap that a cause must close to be called one; a false name closes a few percent."""
SIGNIFICANT = 3.0
SIGNIFICANT_SHAPE = 2.0
"""Standard deviations to which its shape must be known: hysteresis over no deflection at all is dry friction."""
OWN_ERROR = 1e-3
"""Change of the prediction, relative, that the method's own error may make."""
ITERATIONS = 10
ROUNDS = 6
"""Rounds of a refit that has a long way to go, the noise taken anew in each: a spring that stiffens makes its resonance
jump, and weights that expect the first residual hold it back."""
WORTH_ANOTHER = 0.8
"""Share of the cost that such a round must leave at most for another to follow."""
SKETCH = 2
"""Iterations of a sketch."""
RACE = ((1, 4), (2, 2), (4, 1))
"""Rounds of the race among shapes of one effect: iterations, and how many go on."""
SIZES = (1.0, 0.4, 0.12)
"""Shares of the linear estimate of an effect's size from which the refit may start."""


@dataclass(frozen=True)
class Trial:
    """A refit with one more effect: fall of the BIC, what left-out blocks say, share of the closable gap closed."""

    candidate: Candidate
    solver: GapFit
    fit: Fit
    evidence: float
    held_out: HeldOut
    share: float
    excess: float
    """What is left above the noise, relative to the noise, by energy."""
    objection: str

    @property
    def effect(self) -> str:
        """The effect's name."""
        return self.candidate.effect


def excess_of(solver: GapFit, fit: Fit) -> float:
    """Energy of the whitened residual above the noise, relative to it; the noise estimated from this residual."""
    residual = solver.whitened_residual(fit.values, solver.whitenings(fit.values))
    return float(residual @ residual) / residual.size - 1.0


def effects_in(keys: Sequence[str]) -> tuple[str, ...]:
    """Names of the effects among flat keys."""
    return tuple(dict.fromkeys(e for e in map(effect_in, keys) if e is not None))


def extended_solver(solver: GapFit, free: Sequence[str], *added: Candidate) -> tuple[GapFit, tuple[str, ...]]:
    """The solver and free keys with more effects; a measurement key that an effect takes over is dropped."""
    effects = (*effects_in(free), *(c.effect for c in added))
    extended = GapFit(solver.problem, priors=gap_priors(solver.problem, effects), marks=solver.marks)
    own = tuple(k for c in added for k in c.keys)
    dropped = [c.replaces for c in added]
    return extended, (*(k for k in free if k not in dropped and k not in own), *own)


def sketched(solver: GapFit, fit: Fit, score: Score) -> Fit:
    """A rough refit with a candidate: what it promises once the whole model follows. Raises ExcitationError."""
    extended, keys = extended_solver(solver, fit.free, score.candidate)
    starts = starts_of(solver, fit, score)
    fits = [extended.solve(keys, s, fit.whitenings, iterations=SKETCH, tolerance=1e-3, rough=True) for s in starts]
    return min(fits, key=lambda f: f.cost / _torque_energy(extended, f))


def _torque_energy(solver: GapFit, fit: Fit) -> float:
    """Sum of squares of the torque as measured under a model: a limit that clips all of it leaves no error either."""
    torque = solver.problem.measured_torque(fit.values)[solver.problem.usable]
    return float(torque @ torque)


def starts_of(solver: GapFit, fit: Fit, score: Score) -> list[Mapping[str, float]]:
    """Where a refit may start: near the fit without the candidate and, if that is far off, from anew."""
    near = best_start(solver, fit, score)
    return [near, {**fit.values, **score.candidate.anew}] if score.candidate.anew else [near]


def tried(
    solver: GapFit, fit: Fit, candidate: Candidate, starts: Sequence[Mapping[str, float]], own_error: float
) -> Trial:
    """The candidate, refitted with everything else from the best of `starts`. Raises ExcitationError.

    `own_error` is what the model without it may be wrong by itself (`own_error_of`).
    """
    extended, keys = extended_solver(solver, fit.free, candidate)
    after = _refitted(extended, keys, starts, fit)
    return compared(extended, fit, after, candidate, own_error)


def compared(solver: GapFit, before: Fit, after: Fit, candidate: Candidate, own_error: float) -> Trial:
    """What speaks for and against `after`, fitted by `solver`, which has the candidate, and `before`, which has not."""
    count = after.residual.size / correlation_factor(after)
    price = len(candidate.keys) * math.log(count) + 2.0 * math.log(len(CATALOGUE))
    evidence = log_likelihood_gain(before, after) - price
    held = held_out_comparison(solver.problem, before, after)
    excess, excess_before, share = closed_share(solver, before, after)
    imitable = effect_named(candidate.effect).imitable * own_error
    objection = _objection(solver, before, after, candidate, evidence, held, (excess_before, share), imitable)
    return Trial(candidate, solver, after, evidence, held, share, excess, objection)


def best_start(solver: GapFit, fit: Fit, score: Score) -> dict[str, float]:
    """Where a refit starts: the effect at the linear estimate or less, the model following it."""
    candidate = score.candidate
    solver, _ = extended_solver(solver, fit.free, candidate)
    whole = candidate.start(score.sizes)
    dropped = candidate.replaces
    kept = [i for i, k in enumerate(fit.free) if k != dropped and k not in fit.at_bound]
    jacobian = fit.jacobian[:, kept]
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    options: list[dict[str, float]] = []
    for size in SIZES:
        values = {**fit.values, **{k: v * size if k in candidate.scaled else v for k, v in whole.items()}}
        if dropped:
            values[candidate.keys[0]] += fit.values.get(dropped, 0.0)
            values[dropped] = 0.0
        options.append(values)
    residuals = solver.whitened_residuals(options, fit.whitenings)
    finite = [(v, r) for v, r in zip(options, residuals, strict=True) if np.isfinite(r).all()]
    followed: list[dict[str, float]] = []
    for values, residual in finite:
        step = np.linalg.lstsq(jacobian / scale, -residual, rcond=1e-6)[0] / scale
        moved = dict(values)
        for i, change in zip(kept, step, strict=True):
            key = fit.free[i]
            now = values[key] + float(change)
            low, high = key_bounds(key, solver.priors)
            if key_named(key).logarithmic:
                now = float(np.clip(now, 0.5 * values[key], 2.0 * values[key]))
            moved[key] = float(np.clip(now, low, high))
        followed.append(moved)
    tried_out = [*finite, *zip(followed, solver.whitened_residuals(followed, fit.whitenings), strict=True)]
    costs = [(float(r @ r), i) for i, (_, r) in enumerate(tried_out) if np.isfinite(r).all()]
    return tried_out[min(costs)[1]][0] if costs else {**fit.values, **whole}


def _refitted(solver: GapFit, keys: tuple[str, ...], starts: Sequence[Mapping[str, float]], fit: Fit) -> Fit:
    """The fit from the best start, after a short race among several: a narrow resonance has many minima."""
    if len(starts) == 1:
        return _descended(solver, keys, starts[0], fit)
    race: list[Mapping[str, float]] = list(starts)
    for iterations, kept in RACE:
        fits = []
        for start in race:
            try:
                fits.append(
                    solver.solve(keys, start, fit.whitenings, iterations=iterations, tolerance=1e-3, rough=True)
                )
            except ExcitationError:  # the simulation ran away from there
                continue
        race = [f.values for f in sorted(fits, key=lambda f: f.cost)[:kept]]
    if not race:
        raise ExcitationError("no shape of the effect can be simulated.")
    return _descended(solver, keys, race[0], fit)


def _descended(solver: GapFit, keys: tuple[str, ...], start: Mapping[str, float], fit: Fit) -> Fit:
    """The fit from one start, under the noise of the fit without the candidate; on a long way with noise taken anew."""
    found = solver.solve(keys, start, fit.whitenings, iterations=ITERATIONS, tolerance=1e-4)
    for _ in range(ROUNDS):
        if found.converged:
            break
        values = found.values
        ahead = solver.solve(keys, values, solver.whitenings(values), iterations=ITERATIONS, tolerance=1e-3, rough=True)
        again = solver.solve(keys, ahead.values, fit.whitenings, iterations=ITERATIONS, tolerance=1e-4)
        done = again.cost > WORTH_ANOTHER * found.cost
        found = again if again.cost < found.cost else found
        if done:
            break
    return found


def without(solver: GapFit, fit: Fit, base: Sequence[str], kept: Sequence[Candidate]) -> Fit:
    """The model of a fit refitted with only some of its effects, on the free keys of the base."""
    reduced, keys = extended_solver(solver, base, *kept)
    values = {k: v for k, v in fit.values.items() if k in keys or effect_in(k) is None}
    return reduced.solve(keys, values, fit.whitenings, iterations=ITERATIONS, tolerance=1e-4)


def closed_share(solver: GapFit, before: Fit, after: Fit) -> tuple[float, float, float]:
    """Excess after and before, and share of the closable gap closed; the noise is what the refitted residual shows."""
    whitenings = solver.whitenings(after.values)
    left = solver.whitened_residual(after.values, whitenings)
    had = solver.whitened_residual(before.values, whitenings)
    excess = float(left @ left) / left.size - 1.0
    excess_before = float(had @ had) / had.size - 1.0
    if excess_before <= 0.0:
        return excess, excess_before, 0.0
    return excess, excess_before, 1.0 - max(excess, 0.0) / excess_before


def _objection(
    solver: GapFit, before: Fit, fit: Fit, candidate: Candidate, evidence: float, held: HeldOut,
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
    change = _change(solver, before, fit)
    if change < own_error:
        return (
            f"it changes the prediction by {100 * change:.2f} % only; what is in the model already may be wrong by "
            f"{100 * own_error:.2f} %"
        )
    rise = _torque_rms(solver, fit) / _torque_rms(solver, before) - 1.0
    if rise > 0.002:
        return f"the torque's gap grows by {100 * rise:.1f} % with it"
    bound = [k for k in candidate.keys if k in fit.at_bound and not parameter_named(k).angle]
    if bound:
        return f"{bound[0]} ends at the limit of what is physical ({fit.values[bound[0]]:.3g})"
    cycles = fit.values.get(key_text(candidate.effect, effect_named(candidate.effect).cycles), math.inf)
    if cycles * float(np.ptp(solver.problem.motion.position)) < LEAST_PERIODS * 2.0 * math.pi:
        return "it shows a part of one period only within the range of motion"
    weak = _weakest(solver, fit, candidate.scaled)
    if weak is not None:
        return f"{weak[0]} is known to {weak[1]:.1f} standard deviations only, {SIGNIFICANT:.0f} needed"
    shape = [k for k in candidate.keys if k not in candidate.scaled and not parameter_named(k).angle]
    vague = _weakest(solver, fit, shape, SIGNIFICANT_SHAPE) if shape else None
    if vague is not None:
        return f"its shape is not determined: {vague[0]} is known to {vague[1]:.1f} standard deviations"
    if candidate.replaces:
        value, period = abs(fit.values[candidate.keys[0]]), solver.problem.recording.sample_time
        if value < period:
            return f"{1e3 * value:.2f} ms is less than one sample: measurement, corrected for"
    if share < SMALLEST_SHARE:
        return f"it closes {100 * share:.0f} % of the gap only, {100 * SMALLEST_SHARE:.0f} % needed for a cause"
    return ""


def own_error_of(solver: GapFit, accepted: Sequence[tuple[str, Fit, Fit]]) -> float:
    """Change of the prediction, relative, that method and laws may make: effects with the fits before and after."""
    laws = [effect_named(name).law_error * _change(solver, before, after) for name, before, after in accepted]
    return max(OWN_ERROR, math.hypot(*laws))


def _change(solver: GapFit, before: Fit, after: Fit) -> float:
    """By how much the prediction changes, relative to the torque or the deflection, whichever changes more."""
    problem, rows = solver.problem, solver.problem.usable
    sizes = [float(np.std(problem.torque[rows]))]
    if problem.link is not None:
        sizes.append(float(np.std((problem.motion.position[:: problem.decimation] - problem.link)[rows])))
    one, two = problem.residuals(before.values), problem.residuals(after.values)
    return max(float(np.std((b - a)[rows])) / size for a, b, size in zip(one, two, sizes, strict=True))


def _torque_rms(solver: GapFit, fit: Fit) -> float:
    residual = solver.problem.residuals(fit.values)[0][solver.problem.usable]
    return float(np.sqrt(np.mean(residual**2)))


def _weakest(solver: GapFit, fit: Fit, keys: Sequence[str], least: float = SIGNIFICANT) -> tuple[str, float] | None:
    """The best-known of the keys with its ratio to its standard deviation, when even that is less than `least`."""
    uncertainty = uncertainty_of(fit, solver.problem.rate_hz)
    ratios = []
    for key in keys:
        std = uncertainty.std(key)
        ratios.append((key, abs(fit.values[key]) / std if std > 0 and np.isfinite(std) else 0.0))
    best = max(ratios, key=lambda item: item[1])
    return best if best[1] < least else None


def final_polish(solver: GapFit, fit: Fit) -> Fit:
    """The fit converged once more with the noise's whitening taken from what is left."""
    return solver.solve(fit.free, fit.values, solver.whitenings(fit.values), iterations=ITERATIONS, tolerance=1e-6)
