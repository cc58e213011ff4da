"""Design of the band-limited derivative filter: eqs. 22 to 29 of Pham, Gautier and Poignet (2001)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from flex_ident.errors import UsageError
from flex_ident.parameters import FilterSettings
from flex_ident.recording import Floats

EDGE_GAIN = math.sqrt(0.5)
"""A_c: -3 dB at the edge of the bandwidth."""
BANDWIDTH_IN_MODES = 6.0
"""omega_c over the first mode (section 4 of the paper)."""
DECIMATED_IN_MODES = 5.398 / 3.9
"""Cutoff of the decimation over the first mode (section 4: 5.4 Hz for 3.9 Hz)."""
DECIMATE_SHARE = 0.8
"""Cutoff of Matlab's decimate over the new Nyquist frequency."""


def lowpass_magnitude(frequency_rad_s: Floats, cutoff_rad_s: float, order: int) -> Floats:
    """Magnitude of the forward and reverse Butterworth filter (eq. 25); `order` is that of one pass."""
    magnitude: Floats = 1.0 / (1.0 + (np.asarray(frequency_rad_s) / cutoff_rad_s) ** (2 * order))
    return magnitude


def difference_magnitude(frequency_rad_s: Floats, sample_rate_hz: float, derivative_order: int) -> Floats:
    """Gain of `derivative_order` central differences over the ideal derivative (eq. 24): sinc to that power."""
    x = np.asarray(frequency_rad_s) / sample_rate_hz / math.pi
    magnitude: Floats = np.sinc(x) ** derivative_order
    return magnitude


def butterworth_cutoff_rad_s(
    bandwidth_rad_s: float, order: int, *, edge_gain: float = EDGE_GAIN, ratio: float = 1.0
) -> float:
    """Low-pass cutoff, rad/s, that leaves `edge_gain` of the signal at the edge of the bandwidth.

    Pham, Gautier and Poignet (2001), eq. 28: `edge_gain` is A_c, `ratio` r_c, the low-pass' share of the distortion
    over the differences'. `order` is that of one pass; the filter runs forward and back. Raises UsageError.
    """
    _check(bandwidth_rad_s, order, edge_gain, ratio)
    return float(bandwidth_rad_s * (1.0 / math.sqrt(ratio * edge_gain) - 1.0) ** (-1.0 / (2 * order)))


def sampling_rate_hz(
    bandwidth_rad_s: float, derivative_order: int, *, edge_gain: float = EDGE_GAIN, ratio: float = 1.0
) -> float:
    """Sampling rate, Hz, at which `derivative_order` central differences lose no more than their share at the edge.

    Pham, Gautier and Poignet (2001), eq. 29: sinc(x_c) = (A_c / r_c)^(1 / (2 n_d)). Raises UsageError.
    """
    _check(bandwidth_rad_s, derivative_order, edge_gain, ratio)
    goal = (edge_gain / ratio) ** (1.0 / (2 * derivative_order))
    if goal >= 1.0:
        raise UsageError(f"A_c / r_c is {edge_gain / ratio:.3g}: it must be below 1.")
    x = optimize.brentq(lambda x: np.sinc(x) - goal, 1e-9, 1.0)
    return float(2.0 / x * bandwidth_rad_s / (2.0 * math.pi))


def _check(bandwidth_rad_s: float, order: int, edge_gain: float, ratio: float) -> None:
    if not bandwidth_rad_s > 0.0 or order < 1:
        raise UsageError(f"bandwidth {bandwidth_rad_s:.4g} rad/s and order {order}: both must be positive.")
    if not (0.0 < edge_gain < 1.0 and ratio > 0.0 and ratio * edge_gain < 1.0):
        raise UsageError(f"A_c {edge_gain:.4g} must lie in 0 to 1, r_c {ratio:.4g} be positive and A_c r_c below 1.")


@dataclass(frozen=True)
class FilterDesign:
    """A designed filter: bandwidth, cutoff, the rate it needs, and the decimation of the paper's section 4."""

    first_mode_hz: float
    derivative_order: int
    order: int
    bandwidth_rad_s: float
    cutoff_rad_s: float
    required_rate_hz: float
    sample_rate_hz: float
    decimation: int

    @property
    def decimation_cutoff_hz(self) -> float:
        """Cutoff of the decimation's low-pass, Hz."""
        return DECIMATE_SHARE * self.sample_rate_hz / 2.0 / self.decimation

    def settings(self) -> FilterSettings:
        """The part that travels with a result."""
        return FilterSettings(self.bandwidth_rad_s, self.cutoff_rad_s, self.order, self.sample_rate_hz, self.decimation)


def filter_design(
    first_mode_hz: float,
    *,
    derivative_order: int,
    order: int | None = None,
    sample_rate_hz: float | None = None,
    edge_gain: float = EDGE_GAIN,
    ratio: float = 1.0,
    bandwidth_in_modes: float = BANDWIDTH_IN_MODES,
    decimation: int | None = None,
) -> FilterDesign:
    """The filter for a first mode, as in section 4: omega_c = 6 omega_1, m = 4 (nd = 2) or 6 (nd = 4).

    Without `sample_rate_hz` the rate of eq. 29 is taken. Raises UsageError on numbers out of range.
    """
    if not 0.0 < first_mode_hz < math.inf:
        raise UsageError(f"first mode is {first_mode_hz:g} Hz: it must be positive and finite.")
    if sample_rate_hz is not None and not 0.0 < sample_rate_hz < math.inf:
        raise UsageError(f"sampling rate is {sample_rate_hz:g} Hz: it must be positive and finite.")
    if decimation is not None and decimation < 1:
        raise UsageError(f"decimation is {decimation}: expected a whole number from 1 on.")
    order = order if order is not None else (4 if derivative_order <= 2 else 6)
    bandwidth = bandwidth_in_modes * 2.0 * math.pi * first_mode_hz
    required = sampling_rate_hz(bandwidth, derivative_order, edge_gain=edge_gain, ratio=ratio)
    rate = sample_rate_hz if sample_rate_hz is not None else required
    cutoff = butterworth_cutoff_rad_s(bandwidth, order, edge_gain=edge_gain, ratio=ratio)
    keep = decimation
    if keep is None:
        keep = max(1, round(DECIMATE_SHARE * rate / 2.0 / (DECIMATED_IN_MODES * first_mode_hz)))
    return FilterDesign(first_mode_hz, derivative_order, order, bandwidth, cutoff, required, rate, keep)
