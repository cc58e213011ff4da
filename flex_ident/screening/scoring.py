"""Candidates ranked without refitting: what each would explain of the residual beyond the model's own parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from flex_ident.effects import CATALOGUE
from flex_ident.likelihood.cores import mapped
from flex_ident.likelihood.fit import Fit, SimulationFit
from flex_ident.likelihood.gauge import prior_root
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.screening.candidates import Candidate, refined_candidates
from flex_ident.screening.linear_probe import (
    encoder_error_change,
    mount_change,
    second_mode_change,
    transmission_error_change,
)
from flex_ident.screening.thresholds import IMITATED
from flex_ident.simulation.harmonics import acting, transmission_error
from flex_ident.simulation.terms import MOTOR_ENCODER_ERRORS, Term


@dataclass(frozen=True)
class Score:
    """What a candidate promises: twice the log-likelihood it would gain, and how much of it the model cannot mimic.

    `orthogonal` is the share of its signature, by norm, beyond the model's own parameters; `mark` the size of that
    part, in standard deviations of the noise, for the largest plausible effect. `sizes` are the linear estimates for
    each probe, or the largest plausible size where the linear estimate has a sign that the effect cannot have.
    """

    candidate: Candidate
    gain: float
    orthogonal: float
    mark: float
    sizes: tuple[float, ...]
    shift: Floats | None = None
    """Change (p,) of the free values that goes with the effect at its linear estimate; None where it has none."""


def scores(solver: SimulationFit, fit: Fit, tried: Iterable[Candidate]) -> list[Score]:
    """The best score of each effect, best first. Probes are simulated at finite size, on all cores."""
    bases = {drop: orthonormal(fit, drop) for drop in {e.replaces for e in CATALOGUE.values()}}
    following = following_of(fit)

    def scored(candidate: Candidate) -> Score | None:
        return _score(solver, fit, candidate, bases[candidate.replaces], following)

    samples = solver.problem.motion.position.size
    best = _best(mapped(scored, tried, samples=samples))
    finer = [c for s in best.values() for c in refined_candidates(s.candidate)]
    best = _best([*best.values(), *mapped(scored, finer, samples=samples)])
    return sorted(best.values(), key=lambda s: -s.gain)


def _best(found: Iterable[Score | None]) -> dict[tuple[str, str], Score]:
    best: dict[tuple[str, str], Score] = {}
    for score in found:
        if score is None:
            continue
        key = (score.candidate.effect, score.candidate.side)
        known = best.get(key)
        if known is None:
            best[key] = score
        else:
            better = score if score.gain > known.gain else known
            best[key] = replace(better, mark=max(score.mark, known.mark))
    return best


def orthonormal(fit: Fit, drop: str) -> Floats:
    """Orthonormal columns (r, k) of what the model's own free parameters can do without the nuisance `drop`.

    An effect that takes a nuisance over need not compete with another such one that is at its end: a delay confined to
    a sample and a low-pass, or the other way round, are alike in small changes.
    """
    out = {drop} | ({e.replaces for e in CATALOGUE.values()} & set(fit.at_bound) if drop else set())
    kept = [i for i, key in enumerate(fit.free) if key not in out]
    jacobian = fit.jacobian[:, kept]
    scale = np.linalg.norm(jacobian, axis=0)
    jacobian = jacobian[:, scale > 0.0] / scale[scale > 0.0]
    u, singular, _ = np.linalg.svd(jacobian, full_matrices=False)
    basis: Floats = u[:, singular > 1e-7 * singular[0]]
    return basis


def whitened_change(solver: SimulationFit, fit: Fit, values: Values) -> Floats:
    """Change (r,) of the whitened residual when the model takes other values."""
    terms = solver.problem.terms(values)
    if terms[Term.MOUNT_INERTIA] != 0.0:
        return solver.whitened(mount_change(solver.problem, fit.values, terms), fit.whitenings)
    if terms[Term.SECOND_INERTIA] != 0.0:
        return solver.whitened(second_mode_change(solver.problem, fit.values, terms), fit.whitenings)
    if acting(terms, MOTOR_ENCODER_ERRORS):
        return solver.whitened(encoder_error_change(solver.problem, fit.values, values), fit.whitenings)
    if transmission_error(terms):
        return solver.whitened(transmission_error_change(solver.problem, fit.values, values), fit.whitenings)
    moved = solver.whitened_residual(fit.values | values, fit.whitenings)
    return moved - fit.residual


def following_of(fit: Fit) -> Floats:
    """How the model's free values follow (p, r) a change of the whitened residual that is to be made up for."""
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    rows = np.concatenate((fit.jacobian[:, inside], prior_root(fit.prior_information[np.ix_(inside, inside)])))
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0.0] = 1.0
    following = np.zeros((len(fit.free), fit.residual.size))
    following[inside] = -np.linalg.pinv(rows / scale, rcond=1e-7)[:, : fit.residual.size] / scale[:, None]
    return following


def _score(solver: SimulationFit, fit: Fit, candidate: Candidate, basis: Floats, following: Floats) -> Score | None:
    columns = np.column_stack([whitened_change(solver, fit, p) for p in candidate.probes])
    found = projected(fit, columns, basis, following)
    if found is None:
        return None
    mark = candidate.plausible * found.seen
    if found.orthogonal < IMITATED:
        return Score(candidate, 0.0, found.orthogonal, mark, (candidate.plausible,) * len(found.sizes))
    if candidate.probe.one_sided and found.sizes[0] <= 0.0:
        return Score(candidate, 0.0, found.orthogonal, mark, (candidate.plausible,))
    # The gain of a full step is bounded by what the probe itself would do when the effect is not linear in its size.
    return Score(candidate, found.gain, found.orthogonal, mark, found.sizes, found.shift)


@dataclass(frozen=True)
class Projection:
    """What columns explain of a residual beyond the model's own parameters: twice the log-likelihood gained, the
    share of the columns beyond them, the size of that part, the sizes of the columns, the model's shift (p,) with
    them."""

    gain: float
    orthogonal: float
    seen: float
    sizes: tuple[float, ...]
    shift: Floats


def projected(fit: Fit, columns: Floats, basis: Floats, following: Floats) -> Projection | None:
    """The least-squares sizes of whitened columns (r, k); None where one of them is nothing or not finite."""
    if not np.isfinite(columns).all():
        return None
    whole = np.linalg.norm(columns, axis=0)
    if not (whole > 0.0).all():
        return None
    rest = columns - basis @ (basis.T @ columns)
    seen = np.linalg.norm(rest, axis=0)
    residual = fit.residual - basis @ (basis.T @ fit.residual)
    solution, *_ = np.linalg.lstsq(rest, -residual, rcond=1e-9)
    gain = float(np.linalg.norm(rest @ solution)) ** 2
    return Projection(
        gain,
        float(np.max(seen / whole)),
        float(np.max(seen)),
        tuple(map(float, solution)),
        following @ (columns @ solution),
    )
