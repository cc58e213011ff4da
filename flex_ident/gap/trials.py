"""A candidate refitted together with the whole model, and what speaks for and against accepting it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.estimation.covariance import uncertainty_of
from flex_ident.estimation.fit import LOGARITHMIC, Fit, key_bounds
from flex_ident.gap.candidates import REPLACES, Candidate
from flex_ident.gap.fitting import (
    GapFit,
    HeldOut,
    correlation_factor,
    gap_priors,
    held_out_comparison,
    log_likelihood_gain,
    sum_of_squares,
)
from flex_ident.gap.screening import Score

EVIDENCE = 10.0
"""Fall of the Bayesian information criterion from which a candidate counts (Kass and Raftery: very strong)."""
HELD_OUT_T = 2.5
CLEAR_SHARE = 0.4
"""Share of the cost on left-out data whose fall speaks for itself, be it all in a few seconds of resonance."""
SMALLEST_SHARE = 0.2
"""Share of the closable gap that a cause must close to be called one; a false name closes a few percent."""
SIGNIFICANT = 3.0
ITERATIONS = 10
RACE, FINALISTS = 4, 2
"""Iterations of the race among shapes of one effect, and how many go on from it."""
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


def effects_in(fit: Fit) -> tuple[str, ...]:
    """Names of the effects among a fit's free keys."""
    return tuple(dict.fromkeys(k.split(".")[0] for k in fit.free if "." in k))


def extended_solver(solver: GapFit, fit: Fit, candidate: Candidate) -> tuple[GapFit, tuple[str, ...]]:
    """The solver and free keys with one more effect; a measurement key that the effect takes over is dropped."""
    effects = (*effects_in(fit), candidate.effect)
    extended = GapFit(solver.problem, priors=gap_priors(solver.problem, effects))
    dropped = REPLACES.get(candidate.effect, "")
    keys = tuple(k for k in fit.free if k != dropped and k not in candidate.keys)
    return extended, (*keys, *candidate.keys)


def tried(
    solver: GapFit, fit: Fit, score: Score, *, tried_effects: int, alternatives: Sequence[Candidate] = ()
) -> Trial:
    """The candidate of a score, refitted with everything else from the fit so far.

    `alternatives` are the same effect in other shapes: the refit starts from the one that helps most as it stands.
    """
    candidate = score.candidate
    extended, keys = extended_solver(solver, fit, candidate)
    starts = [_best_start(extended, fit, candidate, score.sizes)]
    starts += [{**fit.values, **other.base, **other.start((1.0,))} for other in alternatives]
    after = _refitted(extended, keys, starts, fit)
    count = after.residual.size / correlation_factor(after)
    price = len(candidate.keys) * math.log(count) + 2.0 * math.log(max(tried_effects, 1))
    evidence = log_likelihood_gain(fit, after) - price
    held = held_out_comparison(solver.problem, fit, after)
    excess, share = _closed(extended, fit, after)
    return Trial(
        candidate,
        extended,
        after,
        evidence,
        held,
        share,
        excess,
        _objection(extended, fit, after, candidate, evidence, held, share),
    )


def _best_start(solver: GapFit, fit: Fit, candidate: Candidate, sizes: tuple[float, ...]) -> dict[str, float]:
    """Where the refit starts: the effect at the linear estimate or less, the model following it."""
    whole = candidate.start(sizes)
    dropped = REPLACES.get(candidate.effect, "")
    kept = [i for i, k in enumerate(fit.free) if k != dropped and k not in fit.at_bound]
    jacobian = fit.jacobian[:, kept]
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    best: tuple[float, dict[str, float]] | None = None
    for size in SIZES:
        effect = {k: v * size if k in candidate.scaled else v for k, v in whole.items()}
        values = {**fit.values, **effect}
        if dropped:
            values[candidate.keys[0]] += fit.values.get(dropped, 0.0)
            values[dropped] = 0.0
        residual = solver.whitened_residual(values, fit.whitenings)
        if not np.isfinite(residual).all():
            continue
        step = np.linalg.lstsq(jacobian / scale, -residual, rcond=1e-6)[0] / scale
        followed = dict(values)
        for i, change in zip(kept, step, strict=True):
            key = fit.free[i]
            now = values[key] + float(change)
            low, high = key_bounds(key, solver.priors)
            if key in LOGARITHMIC:
                now = float(np.clip(now, 0.5 * values[key], 2.0 * values[key]))
            followed[key] = float(np.clip(now, low, high))
        for option in (values, followed):
            left = solver.whitened_residual(option, fit.whitenings)
            cost = float(left @ left)
            if np.isfinite(cost) and (best is None or cost < best[0]):
                best = (cost, option)
    return best[1] if best is not None else {**fit.values, **whole}


def _refitted(solver: GapFit, keys: tuple[str, ...], starts: Sequence[dict[str, float]], fit: Fit) -> Fit:
    """The fit from the best start, after a short race among several: a narrow resonance has many minima."""
    if len(starts) == 1:
        return solver.solve(keys, starts[0], fit.whitenings, iterations=ITERATIONS, tolerance=1e-4)
    race = []
    for start in starts:
        try:
            race.append(solver.solve(keys, start, fit.whitenings, iterations=RACE, tolerance=1e-3))
        except ExcitationError:  # the simulation ran away from there
            continue
    race.sort(key=lambda f: f.cost)
    ends = [
        solver.solve(keys, f.values, fit.whitenings, iterations=3 * ITERATIONS, tolerance=1e-4)
        for f in race[:FINALISTS]
    ]
    return min(ends, key=lambda f: f.cost)


def _closed(solver: GapFit, before: Fit, after: Fit) -> tuple[float, float]:
    """Excess after, and share of the closable gap closed, the noise being what the refitted residual shows."""
    whitenings = solver.whitenings(after.values)
    left = solver.whitened_residual(after.values, whitenings)
    had = solver.whitened_residual(before.values, whitenings)
    excess = float(left @ left) / left.size - 1.0
    excess_before = float(had @ had) / had.size - 1.0
    if excess_before <= 0.0:
        return excess, 0.0
    return excess, 1.0 - max(excess, 0.0) / excess_before


def _objection(
    solver: GapFit, before: Fit, fit: Fit, candidate: Candidate, evidence: float, held: HeldOut, share: float
) -> str:
    """Why a candidate is not accepted; empty when nothing speaks against it."""
    if evidence < EVIDENCE:
        return (
            f"the likelihood gains too little for its parameters (BIC falls by {evidence:.0f}, {EVIDENCE:.0f} needed)"
        )
    if held.share <= 0.0 or (held.t < HELD_OUT_T and held.share < CLEAR_SHARE):
        return f"data left out of the fit do not confirm it (t = {held.t:.1f} over blocks, {HELD_OUT_T} needed)"
    rise = _torque_rms(solver, fit) / _torque_rms(solver, before) - 1.0
    if rise > 0.002:
        return f"the torque's gap grows by {100 * rise:.1f} % with it"
    bound = [k for k in candidate.keys if k in fit.at_bound and not k.endswith(".phase")]
    if bound:
        return f"{bound[0]} ends at the limit of what is physical ({fit.values[bound[0]]:.3g})"
    weak = _weakest(solver, fit, candidate.scaled)
    if weak is not None:
        return f"{weak[0]} is known to {weak[1]:.1f} standard deviations only, {SIGNIFICANT:.0f} needed"
    if candidate.effect in REPLACES:
        value, period = abs(fit.values[candidate.keys[0]]), solver.problem.recording.sample_time
        if value < period:
            return f"{1e3 * value:.2f} ms is less than one sample: measurement, corrected for"
    if share < SMALLEST_SHARE:
        return f"it closes {100 * share:.0f} % of the gap only, {100 * SMALLEST_SHARE:.0f} % needed for a cause"
    return ""


def _torque_rms(solver: GapFit, fit: Fit) -> float:
    residual = solver.problem.residuals(fit.values)[0][solver.problem.usable]
    return float(np.sqrt(np.mean(residual**2)))


def _weakest(solver: GapFit, fit: Fit, keys: Sequence[str]) -> tuple[str, float] | None:
    """The best-known of the keys with its ratio to its standard deviation, when even that is not significant."""
    uncertainty = uncertainty_of(fit, solver.problem.rate_hz)
    ratios = []
    for key in keys:
        std = uncertainty.std(key)
        ratios.append((key, abs(fit.values[key]) / std if std > 0 and np.isfinite(std) else 0.0))
    best = max(ratios, key=lambda item: item[1])
    return best if best[1] < SIGNIFICANT else None


def final_polish(solver: GapFit, fit: Fit) -> Fit:
    """The fit converged once more with the noise's whitening taken from what is left."""
    return solver.solve(fit.free, fit.values, solver.whitenings(fit.values), iterations=ITERATIONS, tolerance=1e-6)


def energy(fit: Fit) -> float:
    """Mean squared whitened residual."""
    return sum_of_squares(fit) / fit.residual.size
