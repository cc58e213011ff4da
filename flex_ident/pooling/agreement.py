"""Whether two results of one joint agree, over all parameters together and not one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from flex_ident.pooling.thresholds import DIFFER, LEAST_DIRECTION
from flex_ident.recording.recording import Floats


@dataclass(frozen=True)
class Agreement:
    """Chi-square of the difference over `keys`, of `freedom` degrees of freedom, and the chance of as much.

    `farthest` is the parameter that adds most to it, all others taken into account.
    """

    keys: tuple[str, ...]
    chi_square: float
    freedom: int
    chance: float
    farthest: str

    @property
    def agree(self) -> bool:
        """Whether chance alone makes such a difference, in one of a hundred pairs at least."""
        return self.chance >= DIFFER


def agreement(keys: Sequence[str], difference: Floats, covariance: Floats) -> Agreement:
    """The agreement of two results whose parameters `keys` (p,) differ by `difference` (p,) with `covariance` (p, p).

    Directions that the covariance says are known a thousand times better than the parameters are alone count as
    unknown: nothing is that well known of how errors go together.
    """
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = values > LEAST_DIRECTION * values.max()
    along = vectors[:, kept].T @ (difference / scale)
    chi_square = float(np.sum(along**2 / values[kept]))
    parts = (difference / scale) * (vectors[:, kept] @ (along / values[kept]))
    freedom = int(kept.sum())
    farthest = keys[int(np.argmax(parts))]
    return Agreement(tuple(keys), chi_square, freedom, float(chi2.sf(chi_square, freedom)), farthest)
