"""Filtering with decimation is filtering, then dropping samples."""

from __future__ import annotations

import numpy as np
import pytest

from flex_ident.filtering.spectral import SpectralFilter


@pytest.mark.parametrize(
    ("n", "rate", "cutoff", "decimation"),
    [(60001, 1000.0, 36.0, 11), (20000, 500.0, 10.0, 20), (7001, 250.0, 40.0, 2), (64, 100.0, 12.0, 3)],
)
def test_decimation_drops_samples_of_the_filtered(n: int, rate: float, cutoff: float, decimation: int) -> None:
    rng = np.random.default_rng(0)
    signal = 5.0 + 0.01 * np.cumsum(rng.normal(size=n)) + 0.01 * rng.normal(size=n)
    chain = {"delay": 1.5 / rate, "curvature": 0.04 / rate**2}
    whole = SpectralFilter(n, rate, cutoff)(signal, (0, 1), **chain)
    dropped = SpectralFilter(n, rate, cutoff, decimation=decimation)(signal, (0, 1), **chain)
    for one, other in zip(whole, dropped, strict=True):
        assert other.shape == one[::decimation].shape
        inner = slice(2, -2) if n < 100 else slice(None)  # the continuation beyond the ends is of another length
        assert np.max(np.abs(one[::decimation] - other)[inner]) < (1e-2 if n < 100 else 1e-4) * np.std(one)
