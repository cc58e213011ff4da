"""How parameters of one result are uncertain together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.recording.recording import Floats

ROUNDING = 1e-6
"""Asymmetry, and negative eigenvalue of the correlations, that rounding makes."""


@dataclass(frozen=True)
class Covariance:
    """Covariance `matrix` (p, p) of the parameters `keys`, in the squares of their units; what the data leave open is
    not among them.

    `systematic` (p,): the standard deviation that is in the diagonal because of the method itself, and that another
    recording of the same joint would share. Raises ValueError when shapes differ or the matrix is none of a covariance.
    """

    keys: tuple[str, ...]
    matrix: Floats
    systematic: Floats

    def __post_init__(self) -> None:
        matrix, own = np.array(self.matrix, dtype=float), np.array(self.systematic, dtype=float)
        count = len(self.keys)
        if matrix.shape != (count, count) or own.shape != (count,) or len(set(self.keys)) != count:
            raise ValueError(f"covariance of {count} keys has the shape {matrix.shape}, systematic parts {own.shape}")
        if not (np.isfinite(matrix).all() and np.isfinite(own).all()):
            raise ValueError("covariance is not finite")
        scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
        correlation = matrix / np.outer(scale, scale)
        if count and (
            np.max(np.abs(correlation - correlation.T)) > ROUNDING
            or np.min(np.linalg.eigvalsh(0.5 * (correlation + correlation.T))) < -ROUNDING
        ):
            raise ValueError("covariance is not symmetric, or has a negative variance")
        for array, name in ((0.5 * (matrix + matrix.T), "matrix"), (own, "systematic")):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def of(self, keys: Sequence[str]) -> Floats:
        """The part (q, q) of some of the keys. Raises ValueError for one that is not there."""
        rows = [self.keys.index(key) for key in keys]
        part: Floats = self.matrix[np.ix_(rows, rows)]
        return part


def joined_covariance(keys: Sequence[str], matrix: Floats, stds: Sequence[float]) -> Covariance:
    """The covariance whose diagonal is `stds` squared: what they hold beyond `matrix` (p, p) is of each alone.

    Keys whose standard deviation is not finite, or zero, are left out.
    """
    kept = [i for i, std in enumerate(stds) if np.isfinite(std) and std > 0.0]
    full = np.array(matrix, dtype=float)[np.ix_(kept, kept)]
    total = np.square([stds[i] for i in kept])
    beyond = np.maximum(total - np.diag(full), 0.0)
    # An interval that is narrower than the matrix says is one-sided: the matrix gives way.
    shrink = np.sqrt(np.minimum(1.0, total / np.maximum(np.diag(full), 1e-300)))
    return Covariance(tuple(keys[i] for i in kept), full * np.outer(shrink, shrink) + np.diag(beyond), np.sqrt(beyond))
