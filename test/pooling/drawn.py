"""Estimates drawn at random, as a number of recordings of one joint would give them: what is true is known."""

from __future__ import annotations

import numpy as np

from flex_ident.parameters import Covariance, Parameter
from flex_ident.pooling.members import Member

KEYS = ("Jm", "K", "JL", "FVm", "FSm", "FV", "MX", "MY")
TRUTH = np.array([1.0, 1.0e4, 1.6, 8.0, 4.0, 2.0, 0.3, -3.0])
OWN = np.array([0.003, 0.002, 0.002, 0.01, 0.01, 0.01, 0.02, 0.004])
"""Standard deviation of one recording, relative."""
UNITS = ("kg m^2", "N m/rad", "kg m^2", "N m s/rad", "N m", "N m s/rad", "kg m", "kg m")


def correlation(rng: np.random.Generator, size: int = len(KEYS)) -> np.ndarray:
    """Correlations as those of a fit are: some strong, none perfect."""
    factor = rng.normal(size=(size, size))
    matrix = factor @ factor.T + 0.5 * np.eye(size)
    scale = np.sqrt(np.diag(matrix))
    return matrix / np.outer(scale, scale)


def members(
    rng: np.random.Generator, count: int, *, scatter: np.ndarray | None = None, scale: float = 1.0,
    added: np.ndarray | None = None, own: float = 1.0, conditions: list[dict[str, float]] | None = None,
    days: list[float] | None = None,
) -> list[Member]:  # fmt: skip
    """`count` recordings; `scatter` (count, p) is added to the truth relatively, `added` (count, p) as it is; the
    effort is recorded too small by `scale`; `days` (count) are when, from a date on."""
    found = []
    alike = correlation(rng)
    for i in range(count):
        truth = TRUTH * (1.0 if scatter is None else 1.0 + scatter[i]) + (0.0 if added is None else added[i])
        std = own * OWN * np.abs(truth) * np.exp(rng.uniform(-0.7, 0.7)) / scale
        matrix = alike * np.outer(std, std)
        values = rng.multivariate_normal(truth / scale, matrix)
        parameters = tuple(
            Parameter(k, float(v), float(s), u) for k, v, s, u in zip(KEYS, values, std, UNITS, strict=True)
        )
        covariance = Covariance(KEYS, matrix, np.zeros(len(KEYS)))
        found.append(Member(f"bag_{i}", parameters, covariance, {} if conditions is None else conditions[i],
                            start_time_s=0.0 if days is None else 1.7e9 + 86400.0 * days[i]))  # fmt: skip
    return found
