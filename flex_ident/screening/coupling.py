"""What a residual has in common with the motion of other joints: inertial, gyroscopic and gravity coupling."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats

from flex_ident.filtering.spectral import SpectralFilter
from flex_ident.likelihood.comparison import FOLDS, correlation_factor
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.recording import Floats
from flex_ident.screening.scoring import orthonormal
from flex_ident.screening.thresholds import BY_CHANCE, LEAST_SHARE

FOLD_S = 1.0
"""Length of the parts left out in turn, s: of every five, one."""
MOST_JOINTS = 12
"""Joints that are looked at, those that move most first: each has eight columns."""
SAME = 1e-6


@dataclass(frozen=True)
class Coupling:
    """What the other joints' motion explains of a torque residual: `share` of its energy where it was not fitted.

    `chance`: the probability of a fit as good by chance; `share` 0 where it explains nothing there.
    """

    joints: tuple[str, ...]
    share: float
    chance: float

    @property
    def seen(self) -> bool:
        """Whether the residual is in part the other joints' doing."""
        return self.chance < BY_CHANCE and self.share > LEAST_SHARE


def coupling_of(solver: SteadyFit, fit: Fit) -> Coupling | None:
    """What the measured motion of the other joints explains of that fit's residual; None where none moved.

    The whitened residual is regressed on the other joints' accelerations, velocities, sine and cosine of position, and
    products of their velocities with this joint's, filtered alike, what the model's own parameters can do taken out;
    Fisher's test with as many samples as are independent; and each fifth second is predicted by the others.
    """
    problem = solver.problem
    others = problem.recording.others
    if not others:
        return None
    names = sorted(others, key=lambda n: -float(np.ptp(others[n])))[:MOST_JOINTS]
    signals = [column for name in names for column in coupling_signals(problem, others[name])]
    rows, late = fit.rows[0], float(fit.values.get("torque_delay", 0.0))
    nothing = [np.zeros(problem.time.size)] * (len(fit.whitenings) - 1)
    whitened = [
        solver.whitened((problem.reduced(s, delay=late), *nothing), fit.whitenings)[: rows.size] for s in signals
    ]
    basis = orthonormal(fit, "")[: rows.size]
    matrix = np.column_stack(whitened)
    basis, _ = np.linalg.qr(basis)
    target = fit.residual[: rows.size]
    target = target - basis @ (basis.T @ target)
    matrix = matrix - basis @ (basis.T @ matrix)
    size = np.linalg.norm(matrix, axis=0)
    kept = size > SAME * float(np.max(size, initial=0.0))
    matrix = matrix[:, kept] / size[kept]
    if not matrix.shape[1]:
        return Coupling(tuple(names), 0.0, 1.0)
    return Coupling(
        tuple(names), max(0.0, _predicted_share(matrix, target, problem.time[rows])), _chance(matrix, target, fit)
    )


def coupling_signals(problem: FitProblem, position: Floats) -> tuple[Floats, ...]:
    """What another joint at `position` (n,) may load this one with, (n,) each, of unit size."""
    rate = problem.recording.sample_rate_hz
    where, speed, acceleration = SpectralFilter(position.size, rate, problem.cutoff_hz)(position, (0, 1, 2))
    own, here = problem.motion.velocity, problem.motion.position
    return (
        acceleration, speed, np.sin(where), np.cos(where), speed * own, speed * speed, np.sin(where + here),
        np.cos(where + here),
    )  # fmt: skip


def _chance(matrix: Floats, target: Floats, fit: Fit) -> float:
    u, singular, _ = np.linalg.svd(matrix, full_matrices=False)
    u = u[:, singular > SAME * singular[0]]
    explained = float(np.sum((u.T @ target) ** 2))
    left = float(target @ target) - explained
    free = target.size / correlation_factor(fit) - u.shape[1] - len(fit.free)
    if free < 1.0 or left <= 0.0:
        return 1.0
    return float(stats.f.sf(explained / u.shape[1] / (left / free), u.shape[1], free))


def _predicted_share(matrix: Floats, target: Floats, time: Floats) -> float:
    """Share of the target's energy that is predicted where the fit did not look."""
    fold = np.floor(time / FOLD_S).astype(np.int64) % FOLDS
    left = 0.0
    for k in range(FOLDS):
        seen = fold != k
        solution = np.linalg.lstsq(matrix[seen], target[seen], rcond=1e-5)[0]
        left += float(np.sum((target[~seen] - matrix[~seen] @ solution) ** 2))
    total = float(target @ target)
    return 1.0 - left / total if total > 0.0 and math.isfinite(left) else 0.0
