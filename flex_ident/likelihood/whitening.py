"""Autoregressive whitening: on coloured residuals plain least squares is neither best nor honest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

from flex_ident.recording import Floats

FLOOR = 1e-5
"""White noise added to the autocovariance, relative: bounds the gain where the low-pass leaves nothing."""


@dataclass(frozen=True)
class Whitening:
    """A prediction-error filter with `coefficients` (p + 1,), the first 1, and the `scale` of what it leaves."""

    coefficients: Floats
    scale: float

    @property
    def memory(self) -> int:
        """Samples at the start of a stretch that the filter spoils."""
        return self.coefficients.size - 1

    def __call__(self, values: Floats) -> Floats:
        """`values`, (m,) or (m, k), whitened along the first axis to unit variance."""
        filtered: Floats = signal.lfilter(self.coefficients, [1.0], values, axis=0) / self.scale
        return filtered


def settled(usable: NDArray[np.bool_], memory: int) -> NDArray[np.bool_]:
    """Where (m,) a sample and the `memory` before it are all usable."""
    if memory == 0:
        return usable
    bad = np.cumsum(~usable)
    start = np.concatenate((np.zeros(memory + 1, bad.dtype), bad[: -memory - 1])) if bad.size > memory else bad
    inside: NDArray[np.bool_] = (bad - start[: bad.size]) == 0
    inside[:memory] = False
    return inside


def whitening_of(residual: Floats, usable: NDArray[np.bool_], order: int) -> Whitening:
    """The autoregressive model of `order` (Yule and Walker) of a residual (m,) over its usable samples.

    The mean is not removed: a constant residual is as much an error as any other.
    """
    x = np.where(usable, residual, 0.0)
    count = max(int(usable.sum()), 1)
    length = 1 << int(np.ceil(np.log2(2 * x.size)))
    spectrum = np.abs(np.fft.rfft(x, length)) ** 2
    autocovariance = np.fft.irfft(spectrum, length)[: order + 1] / count
    if autocovariance[0] <= 0.0:
        return Whitening(np.ones(1), 1.0)
    autocovariance[0] *= 1.0 + FLOOR
    prediction = linalg.solve_toeplitz(autocovariance[:-1], autocovariance[1:])
    coefficients = np.concatenate(([1.0], -prediction))
    rest = signal.lfilter(coefficients, [1.0], residual)
    rows = settled(usable, order)
    scale = float(np.sqrt(np.mean(rest[rows] ** 2))) if rows.any() else float(np.sqrt(autocovariance[0]))
    return Whitening(coefficients, max(scale, 1e-300))
