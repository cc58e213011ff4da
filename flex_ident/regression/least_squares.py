"""Least squares by singular values, with what the data leave undetermined named."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from flex_ident.errors import ExcitationError
from flex_ident.recording import Floats
from flex_ident.regression.thresholds import STRONG_SHARE

WEAK = 1e-8
"""Singular values below this share of the largest, columns scaled, count as zero."""


@dataclass(frozen=True)
class LinearFit:
    """Solution (p,) of y = W X + rho (eq. 21), its covariance (p, p), and what was left open.

    `undetermined` names, for each singular value that is zero, the columns it mixes.
    """

    names: tuple[str, ...]
    values: Floats
    covariance: Floats
    condition_number: float
    rank: int
    undetermined: tuple[tuple[str, ...], ...]
    residual: Floats

    def value(self, name: str) -> float:
        """The solution for one column."""
        return float(self.values[self.names.index(name)])

    def std(self, name: str) -> float:
        """One standard deviation of one column; infinite when it is undetermined."""
        if any(name in group for group in self.undetermined):
            return math.inf
        i = self.names.index(name)
        return math.sqrt(max(float(self.covariance[i, i]), 0.0))


def least_squares(matrix: Floats, target: Floats, names: Sequence[str], *, lag: int = 0) -> LinearFit:
    """Least squares of `target` (r,) on `matrix` (r, p), columns scaled, by singular values.

    The covariance is that of the paper (residual variance times inverse information) for `lag` 0; else the sandwich
    of Newey and West over so many rows, where that is larger: residuals of filtered data are not independent. Raises
    ExcitationError when there are not more rows than columns.
    """
    rows, columns = matrix.shape
    if rows <= columns + 2:
        raise ExcitationError(
            f"{rows} samples are left for {columns} parameters after filtering and decimation: record longer."
        )
    scale = np.linalg.norm(matrix, axis=0)
    empty = scale == 0.0
    scale[empty] = 1.0
    scaled = matrix / scale
    u, singular, vectors = linalg.svd(scaled, full_matrices=False)
    kept = singular > WEAK * singular[0]
    undetermined = [
        tuple(names[int(i)] for i in np.flatnonzero(np.abs(vector) > STRONG_SHARE)) for vector in vectors[~kept]
    ]
    solution = vectors[kept].T @ ((u[:, kept].T @ target) / singular[kept])
    residual = target - scaled @ solution
    bread = (vectors[kept].T / singular[kept] ** 2) @ vectors[kept]
    variance = float(residual @ residual) / (rows - columns)
    covariance = variance * bread
    if lag > 0:
        scores = scaled * residual[:, None]
        meat = scores.T @ scores
        for k in range(1, min(lag, rows - 1) + 1):
            cross = scores[k:].T @ scores[:-k]
            meat = meat + (1.0 - k / (lag + 1.0)) * (cross + cross.T)
        robust = np.diag(bread @ meat @ bread)
        factor = np.sqrt(np.maximum(1.0, robust / np.maximum(np.diag(covariance), 1e-300)))
        covariance = covariance * np.outer(factor, factor)
    return LinearFit(
        tuple(names),
        solution / scale,
        covariance / np.outer(scale, scale),
        float(singular[0] / singular[-1]) if singular[-1] > 0.0 else math.inf,
        int(kept.sum()),
        tuple(undetermined),
        residual,
    )
