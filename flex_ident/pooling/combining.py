"""Several estimates of one number as one: what scatters between recordings beyond chance is in the interval.

    x_i = mu + b_i + e_i      b_i ~ (0, tau^2) between recordings, e_i ~ (0, s_i^2) each recording's own

tau by Paule and Mandel (J. Res. NBS 87, 1982): the sum of (x_i - mu)^2 / (s_i^2 + tau^2) is n - 1. The interval by
Hartung and Knapp (Statist. Med. 20, 2001), never narrower than without scatter, with the quantile of Student's t.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, t

from flex_ident.pooling.members import MemberValues
from flex_ident.pooling.sessions import session_means, within_sessions
from flex_ident.pooling.thresholds import LEAST_STATISTICAL, TWO_SCATTER
from flex_ident.recording.recording import Floats

NORMAL = 1.96
"""The quantile that a standard deviation of `Parameter` is multiplied by."""


@dataclass(frozen=True)
class Pooled:
    """One number from n: `half` is half the 95 % interval, `scatter` tau, `chance` that of as much scatter without tau.

    `weights` (n,) sum to one; `own` (n,) are the standard deviations without `shared`, what the method itself may be
    wrong by in all recordings alike.
    """

    value: float
    half: float
    scatter: float
    chance: float
    weights: Floats
    own: Floats
    shared: float

    @property
    def std(self) -> float:
        """The standard deviation whose normal interval is the interval."""
        return self.half / NORMAL


def pooled(
    values: Floats, stds: Floats, systematic: Floats | None = None, sessions: Sequence[int] | None = None
) -> Pooled:
    """One number from `values` (n,), each with its standard deviation (n,), of which `systematic` (n,) is shared.

    Two that do not scatter (chance over 20 %) have an interval over both of theirs: one degree of freedom says nothing.
    Values of one of the `sessions` (n) count as one, their mean; those of one session alone tell nothing of others, and
    their scatter is that within it.
    """
    shared = 0.0 if systematic is None else float(np.min(systematic))
    variance: Floats = np.maximum(stds**2 - shared**2, LEAST_STATISTICAL * stds**2)
    count = values.size if sessions is None else len(set(sessions))
    if sessions is None or count in (1, values.size):
        return _pooled(values, variance, shared)
    means, mean_stds, within = session_means(values, np.sqrt(variance), sessions)
    found = _pooled(means, mean_stds**2, shared)
    at = np.unique(np.asarray(sessions), return_inverse=True)[1]
    scatter = float(np.hypot(found.scatter, np.sqrt(within_sessions(values, np.sqrt(variance), at))))
    chance = float(chi2.sf(_spread(values, variance, 0.0), values.size - 1))
    return replace(found, weights=found.weights[at] * within, own=np.sqrt(variance), scatter=scatter, chance=chance)


def _pooled(values: Floats, variance: Floats, shared: float) -> Pooled:
    """One number from values (n,) that are independent but for `shared`."""
    n = values.size
    chance = float(chi2.sf(_spread(values, variance, 0.0), n - 1)) if n > 1 else 1.0
    tau2 = between(values, variance)
    weights = 1.0 / (variance + tau2)
    mean = float(weights @ values / weights.sum())
    if n == 1:
        half = NORMAL * float(np.sqrt(variance[0]))
    elif n == 2 and chance > TWO_SCATTER:
        ends = np.concatenate((values - NORMAL * np.sqrt(variance), values + NORMAL * np.sqrt(variance)))
        half = float(np.max(np.abs(ends - mean)))
    else:
        factor = max(1.0, _spread(values, variance, tau2) / (n - 1))
        half = float(t.ppf(0.975, n - 1) * np.sqrt(factor / weights.sum()))
    half = float(np.hypot(half, NORMAL * shared))
    return Pooled(mean, half, float(np.sqrt(tau2)), chance, weights / weights.sum(), np.sqrt(variance), shared)


def between(values: Floats, variance: Floats) -> float:
    """The variance between recordings, tau^2, of Paule and Mandel; zero where chance makes as much."""
    n = values.size
    if n < 2 or _spread(values, variance, 0.0) <= n - 1:
        return 0.0
    upper = float(np.sum((values - values.mean()) ** 2))
    return float(brentq(lambda x: _spread(values, variance, x) - (n - 1), 0.0, upper, xtol=1e-12 * upper, rtol=1e-10))


def _spread(values: Floats, variance: Floats, tau2: float) -> float:
    """Sum of the squares about the weighted mean, each over its variance."""
    weights = 1.0 / (variance + tau2)
    return float(weights @ (values - weights @ values / weights.sum()) ** 2)


def pooled_all(given: MemberValues) -> tuple[Pooled, ...]:
    """Each parameter (p) by itself, over the recordings that determine it."""
    found = []
    for k in range(len(given.keys)):
        rows = given.there[:, k]
        stds = np.sqrt(given.covariances[rows, k, k])
        sessions = [s for s, there in zip(given.sessions, rows, strict=True) if there]
        found.append(pooled(given.values[rows, k], stds, given.systematic[rows, k], sessions))
    return tuple(found)


def pooled_covariance(given: MemberValues, found: tuple[Pooled, ...]) -> Floats:
    """Covariance (p, p) of the numbers in `found`: each recording's own and the scatter's, by their weights.

    How parameters scatter together is taken from the recordings, drawn towards not at all where they are few.
    """
    n, p = given.values.shape
    weights = np.zeros((n, p))
    left = np.zeros((n, p))
    for k, own in enumerate(found):
        rows = given.there[:, k]
        weights[rows, k] = own.weights
        if own.scatter > 0.0:
            left[rows, k] = given.values[rows, k] - own.value
    size = np.sqrt(np.sum(left**2, axis=0))
    alike = (left / np.where(size > 0.0, size, 1.0)).T @ (left / np.where(size > 0.0, size, 1.0))
    share = (n - 1.0) / (n - 1.0 + p)
    together = share * alike + (1.0 - share) * np.eye(p)
    np.fill_diagonal(together, 1.0)
    tau = np.array([own.scatter for own in found])
    between_all = together * np.outer(tau, tau)
    total = np.zeros((p, p))
    for i in range(n):
        total += given.covariances[i] * np.outer(weights[i], weights[i])
    for session in set(given.sessions):
        own = weights[np.asarray(given.sessions) == session].sum(axis=0)
        total += between_all * np.outer(own, own)
    scale = np.array([own.std for own in found]) / np.sqrt(np.maximum(np.diag(total), 1e-300))
    matrix: Floats = total * np.outer(scale, scale)
    return matrix
