"""The noise under a residual that still holds model error: its spectrum, its whitening filter, its floor."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, ndimage

from flex_ident.estimation.whitening import FLOOR, Whitening
from flex_ident.recording import Floats

SEGMENT_S = 1.0
QUANTILE = 0.3
"""Model error comes and goes with the motion, noise stays: the lower part of the segments shows the noise."""


def noise_spectrum(residual: Floats, usable: NDArray[np.bool_], rate_hz: float) -> Floats:
    """Two-sided power spectrum (s // 2 + 1,), unit^2 per bin of s samples, of the steady part of a residual (m,).

    At each frequency the 30 % quantile over half-overlapping segments of a second, over what it is for Gaussian
    noise (power is exponentially distributed), then the median over neighbouring frequencies. The lowest bins, where
    a constant error never goes away, are taken from their neighbours.
    """
    size = max(16, 2 * round(0.5 * SEGMENT_S * rate_hz))
    window = np.hanning(size + 1)[:-1]
    starts = [s for s in range(0, residual.size - size + 1, size // 2) if usable[s : s + size].all()]
    if len(starts) < 6:
        starts = list(range(0, residual.size - size + 1, size // 2))
    segments = np.stack([residual[s : s + size] for s in starts]) * window
    power = np.abs(np.fft.rfft(segments, axis=1)) ** 2 / np.sum(window**2)
    level = np.quantile(power, QUANTILE, axis=0) / -math.log(1.0 - QUANTILE)
    level[:3] = np.median(level[3:8])
    smooth: Floats = np.exp(ndimage.median_filter(np.log(np.maximum(level, 1e-300)), 7, mode="nearest"))
    return smooth


def noise_whitening(residual: Floats, usable: NDArray[np.bool_], rate_hz: float, order: int) -> Whitening:
    """The filter that whitens the steady part of a residual (m,) to unit variance; model error stays visible."""
    spectrum = noise_spectrum(residual, usable, rate_hz)
    size = 2 * (spectrum.size - 1)
    autocovariance = np.fft.irfft(spectrum, size)
    order = min(order, size // 2 - 1)
    # A short window over the lags: the spectrum's own estimation noise must not become filter.
    lags = np.arange(order + 1)
    autocovariance = autocovariance[: order + 1] * (0.5 + 0.5 * np.cos(math.pi * lags / (order + 1)))
    if autocovariance[0] <= 0.0:
        return Whitening(np.ones(1), 1.0)
    autocovariance[0] *= 1.0 + FLOOR
    prediction = linalg.solve_toeplitz(autocovariance[:-1], autocovariance[1:])
    coefficients = np.concatenate(([1.0], -prediction))
    variance = float(autocovariance[0] - prediction @ autocovariance[1:])
    return Whitening(coefficients, math.sqrt(max(variance, 1e-300)))


def noise_floor(residual: Floats, usable: NDArray[np.bool_], rate_hz: float) -> float:
    """Root mean square, in the residual's unit, of its steady part."""
    spectrum = noise_spectrum(residual, usable, rate_hz)
    return math.sqrt(float(np.mean(np.fft.irfft(spectrum, 2 * (spectrum.size - 1))[:1])))
