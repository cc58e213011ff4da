"""A rough refit with one more effect: what it promises once the whole model follows it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from flex_ident.effects import effect_named, key_named
from flex_ident.errors import ExcitationError
from flex_ident.likelihood.fit import Fit, key_bounds
from flex_ident.likelihood.gauge import prior_root
from flex_ident.likelihood.nuisances import model_priors
from flex_ident.likelihood.steady import STATE, SteadyFit
from flex_ident.parameters import UNITS
from flex_ident.parameters.effort_kinds import REMOVED_KEYS
from flex_ident.parameters.keys import effect_in
from flex_ident.parameters.prior import Prior
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.screening.candidates import Candidate
from flex_ident.screening.scoring import Score

SIZES = (1.0, 0.4, 0.12)
"""Shares of the linear estimate of an effect's size from which the refit may start."""
SKETCH = 2
"""Iterations of a sketch."""
RACE = ((1, 4), (2, 2), (4, 1))
"""Rounds of the race among shapes of one effect: iterations, and how many go on."""


def effects_in(keys: Sequence[str]) -> tuple[str, ...]:
    """Names of the effects among written keys."""
    return tuple(dict.fromkeys(e for e in map(effect_in, keys) if e is not None))


def known_beforehand(solver: SteadyFit) -> dict[str, Prior]:
    """What a solver knows before the fit for its kind of effort: of first moments, friction, or what is taken off."""
    return {k: p for k, p in solver.priors.items() if k in UNITS or k in REMOVED_KEYS}


def extended_solver(solver: SteadyFit, free: Sequence[str], *added: Candidate) -> tuple[SteadyFit, tuple[str, ...]]:
    """The solver and free keys with more effects; a measurement key that an effect takes over is dropped."""
    effects = (*effects_in(free), *(c.effect for c in added))
    priors = {**known_beforehand(solver), **model_priors(solver.problem, effects, late_samples=1.0)}
    dropped = [key for name in effects for key in effect_named(name).stand_ins]
    priors = {k: p for k, p in priors.items() if k not in dropped}
    dropped += [c.replaces for c in added]
    extended = SteadyFit(solver.problem, priors=priors, marks=solver.marks)
    own = tuple(k for c in added for k in c.keys)
    return extended, (*(k for k in free if k not in dropped and k not in own), *own)


def sketched(solver: SteadyFit, fit: Fit, score: Score) -> Fit:
    """A rough refit with a candidate: what it promises once the whole model follows. Raises ExcitationError."""
    extended, keys = extended_solver(solver, fit.free, score.candidate)
    starts = starts_of(solver, fit, score)
    fits = [extended.solve(keys, s, fit.whitenings, iterations=SKETCH, tolerance=1e-3, rough=True) for s in starts]
    return min(fits, key=lambda f: f.cost / _torque_energy(extended, f))


def _torque_energy(solver: SteadyFit, fit: Fit) -> float:
    """Sum of squares of the torque as measured under a model: a limit that clips all of it leaves no error either."""
    torque = solver.problem.measured_torque(fit.values)[solver.problem.usable]
    return float(torque @ torque)


def starts_of(solver: SteadyFit, fit: Fit, score: Score) -> list[Values]:
    """Where a refit may start: near the fit without the candidate and, if that is far off, from anew."""
    near = best_start(solver, fit, score)
    anew = score.candidate.anew()
    return [near, fit.values | anew] if anew else [near]


def raced_starts(solver: SteadyFit, fit: Fit, score: Score, tried: Iterable[Candidate]) -> list[Values]:
    """Where a refit with an effect of many minima may start: each raced shape of the candidates, and near the fit."""
    shapes = (c for c in tried if c.effect == score.candidate.effect and c.probe.raced)
    starts = [fit.values | c.probe.base | c.start((1.0,)) for c in shapes]
    return [*starts, best_start(solver, fit, score)]


def raced(solver: SteadyFit, keys: Sequence[str], starts: Sequence[Values], fit: Fit) -> Fit:
    """The rough refit over `keys` that wins a short race among several starts. Raises ExcitationError."""
    race, fits = list(starts), list[Fit]()
    for iterations, kept in RACE:
        fits = []
        for start in race:
            try:
                fits.append(
                    solver.solve(keys, start, fit.whitenings, iterations=iterations, tolerance=1e-3, rough=True)
                )
            except ExcitationError:  # the simulation ran away from there
                continue
        fits = sorted(fits, key=lambda f: f.cost)[:kept]
        race = [f.values for f in fits]
    if not fits:
        raise ExcitationError("no shape of the effect can be simulated.")
    return fits[0]


def best_start(solver: SteadyFit, fit: Fit, score: Score) -> Values:
    """Where a refit starts: the effect at the linear estimate or less, the model following it."""
    candidate = score.candidate
    solver, _ = extended_solver(solver, fit.free, candidate)
    whole = candidate.start(score.sizes)
    dropped = candidate.replaces
    kept = [i for i, k in enumerate(fit.free) if k != dropped and k not in fit.at_bound]
    steady = [i for i in kept if fit.free[i] not in STATE]
    options: list[Values] = []
    sized = candidate.probe.sized
    for size in SIZES:
        values = fit.values | {k: sized(v, size) if k in candidate.scaled else v for k, v in whole.items()}
        if dropped:
            first = candidate.keys[0]
            values |= {first: values[first] + fit.values.get(dropped, 0.0), dropped: 0.0}
        options.append(values)
    residuals = solver.whitened_residuals(options, fit.whitenings)
    finite = [(v, r) for v, r in zip(options, residuals, strict=True) if np.isfinite(r).all()]
    followed: list[Values] = []
    for keys, damped in ((kept, False), (steady, True)):
        followed += [v | _following(solver, fit, keys, v, residual, damped=damped) for v, residual in finite]
    tried_out = [*finite, *zip(followed, solver.whitened_residuals(followed, fit.whitenings), strict=True)]
    costs = [(float(r @ r), i) for i, (_, r) in enumerate(tried_out) if np.isfinite(r).all()]
    return tried_out[min(costs)[1]][0] if costs else fit.values | whole


def _following(
    solver: SteadyFit, fit: Fit, kept: Sequence[int], values: Values, residual: Floats, *, damped: bool
) -> dict[str, float]:
    """Where the free keys of these indices go to make up for a residual (r,) at the values, by the fit's Jacobian.

    `damped` by what is known beforehand, lest delay and low-pass run away against each other. A link that sticks at
    first makes the likelihood kink in its state: only a step without that may hold.
    """
    rows = fit.jacobian[:, kept]
    if damped:
        rows = np.concatenate((rows, prior_root(fit.prior_information[np.ix_(kept, kept)])))
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0.0] = 1.0
    wanted = np.concatenate((-residual, np.zeros(rows.shape[0] - residual.size)))
    step = np.linalg.lstsq(rows / scale, wanted, rcond=1e-6)[0] / scale
    moved: dict[str, float] = {}
    for i, change in zip(kept, step, strict=True):
        key = fit.free[i]
        now = values[key] + float(change)
        low, high = key_bounds(key, solver.priors)
        if key_named(key).logarithmic:
            now = float(np.clip(now, 0.5 * values[key], 2.0 * values[key]))
        moved[key] = float(np.clip(now, low, high))
    return moved
