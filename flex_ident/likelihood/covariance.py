"""How uncertain the optimum is, when residuals are coloured, uneven in time and partly model error."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.gauge import prior_root
from flex_ident.likelihood.thresholds import WEAK_SINGULAR_VALUE
from flex_ident.recording import Floats

LAG_S = 1.0
"""Lag up to which scores are taken as correlated, s."""
FRICTION = ("FVm", "FSm", "FV", "FS")
"""Keys that at their bound, nothing, may be more."""
BLOCKS = 24
"""Stretches of time over which the scores' agreement is tested."""


@dataclass(frozen=True)
class Uncertainty:
    """Covariance (p, p) of the free keys and which combinations the data leave open.

    `undetermined` names, for each near-zero singular value, the keys that only their combination is known of.
    """

    free: tuple[str, ...]
    covariance: Floats
    condition_number: float
    rank: int
    undetermined: tuple[tuple[str, ...], ...]

    def std(self, key: str) -> float:
        """One standard deviation of a free key; infinite for one in an undetermined combination, 0 if not free.

        Of a key at its bound: as if there were none.
        """
        if key not in self.free:
            return 0.0
        if any(key in group for group in self.undetermined):
            return float("inf")
        i = self.free.index(key)
        return float(np.sqrt(self.covariance[i, i]))

    def beside(self, shift: Floats | None) -> Uncertainty:
        """The uncertainty with a shift (p,) of the free keys that may be there, one standard deviation."""
        return self if shift is None else replace(self, covariance=self.covariance + np.outer(shift, shift))


def uncertainty_of(fit: Fit, rate_hz: float) -> Uncertainty:
    """Uncertainty of a fit at its optimum.

    The largest, parameter by parameter, of three estimates: inverse information; the sandwich of Newey and West with
    a lag of a second; and the sandwich over `BLOCKS` stretches of time, which also sees model error that pulls one
    part of the recording against another. The correlations are those of the inverse information.
    """
    # Friction at its bound, nothing, may be more: what follows it is as open as it is.
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound or key in FRICTION]
    jacobian = fit.jacobian[:, inside]
    prior = fit.prior_information[np.ix_(inside, inside)]
    names = [fit.free[i] for i in inside]
    p = len(inside)
    information = jacobian.T @ jacobian
    scale = np.sqrt(np.diag(information + prior))
    scale[scale == 0.0] = 1.0
    scaled = np.concatenate((jacobian / scale, prior_root(prior) / scale))
    _, singular, vectors = np.linalg.svd(scaled, full_matrices=False)
    weak = singular < WEAK_SINGULAR_VALUE * singular[0]
    undetermined = []
    for vector in vectors[weak]:
        undetermined.append(tuple(names[i] for i in np.flatnonzero(np.abs(vector) > 0.3)))
    kept = ~weak
    bread = (vectors[kept].T / singular[kept] ** 2) @ vectors[kept]
    count = max(fit.residual.size - p, 1)
    variance = float(fit.residual @ fit.residual) / count
    likelihood = bread * variance if variance > 1.0 else bread
    scores = _scores(fit, jacobian / scale)
    best = np.diag(likelihood).copy()
    for meat in (_newey_west(scores, max(1, int(LAG_S * rate_hz))), _block_meat(scores)):
        best = np.maximum(best, np.diag(bread @ meat @ bread))
    factor = np.sqrt(best / np.maximum(np.diag(likelihood), 1e-300))
    inner = likelihood * np.outer(factor, factor) / np.outer(scale, scale)
    full = np.zeros((len(fit.free), len(fit.free)))
    full[np.ix_(inside, inside)] = inner
    at_bound = [i for i in range(len(fit.free)) if i not in inside]
    if at_bound:
        full[at_bound, at_bound] = _as_if_free(fit, variance)[at_bound]
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf")
    return Uncertainty(fit.free, full, condition, int(kept.sum()), tuple(undetermined))


def _as_if_free(fit: Fit, variance: float) -> Floats:
    """Variances (p,) of all free keys as if none had met its bound: how far from it a key may really lie."""
    information = fit.jacobian.T @ fit.jacobian + fit.prior_information
    scale = np.sqrt(np.diag(information))
    scale[scale == 0.0] = 1.0
    inverse = np.linalg.pinv(information / np.outer(scale, scale), rcond=WEAK_SINGULAR_VALUE**2, hermitian=True)
    found: Floats = np.diag(inverse) / scale**2 * max(variance, 1.0)
    return found


def _scores(fit: Fit, jacobian: Floats) -> Floats:
    """Contribution of each moment (all channels together) to the gradient, (m, p), zero where nothing is used."""
    last = max(int(rows[-1]) for rows in fit.rows if rows.size) + 1
    scores = np.zeros((last, jacobian.shape[1]))
    start = 0
    for rows in fit.rows:
        stop = start + rows.size
        np.add.at(scores, rows, jacobian[start:stop] * fit.residual[start:stop, None])
        start = stop
    used = np.unique(np.concatenate(fit.rows))
    return scores[used]


def _newey_west(scores: Floats, lag: int) -> Floats:
    meat: Floats = scores.T @ scores
    for k in range(1, min(lag, scores.shape[0] - 1) + 1):
        cross = scores[k:].T @ scores[:-k]
        meat = meat + (1.0 - k / (lag + 1.0)) * (cross + cross.T)
    # The weights keep the sum positive; a diagonal below zero can only be rounding.
    return meat


def _block_meat(scores: Floats) -> Floats:
    sums = np.stack([block.sum(axis=0) for block in np.array_split(scores, BLOCKS)])
    meat: Floats = sums.T @ sums * BLOCKS / (BLOCKS - 1.0)
    return meat
