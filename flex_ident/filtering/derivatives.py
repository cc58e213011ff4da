"""The paper's own filtering: zero-phase Butterworth, central differences, decimation."""

from __future__ import annotations

import math

import numpy as np
from scipy import signal

from flex_ident.errors import ExcitationError
from flex_ident.recording import Floats


def zero_phase_lowpass(values: Floats, cutoff_rad_s: float, order: int, sample_rate_hz: float) -> Floats:
    """`values` (n,) through a Butterworth filter forward and back (second-order sections). Raises ExcitationError."""
    nyquist = math.pi * sample_rate_hz
    if cutoff_rad_s >= 0.98 * nyquist:
        raise ExcitationError(
            f"the filter's cutoff, {cutoff_rad_s:.0f} rad/s, lies above half the sampling rate of {sample_rate_hz:.4g} "
            f"Hz: record at {cutoff_rad_s / math.pi * 1.3:.0f} Hz or more, or give a lower --first-mode."
        )
    sections = signal.butter(order, cutoff_rad_s / nyquist, output="sos")
    return _forward_backward(sections, values, "the low-pass")


def _forward_backward(sections: Floats, values: Floats, what: str) -> Floats:
    needed = 3 * (2 * len(sections) + 1)
    if values.shape[0] <= needed:
        raise ExcitationError(f"{values.shape[0]} samples are too few for {what}: at least {needed + 1} are needed.")
    filtered: Floats = signal.sosfiltfilt(sections, values, axis=0)
    return filtered


def central_differences(values: Floats, sample_rate_hz: float, derivative_order: int) -> Floats:
    """The derivative of that order of `values` (n,) by repeated central differences (eq. 22), (n,).

    The first and last `derivative_order` samples are one-sided: drop them.
    """
    result = values
    for _ in range(derivative_order):
        result = np.gradient(result, 1.0 / sample_rate_hz)
    return result


def decimated(columns: Floats, factor: int) -> Floats:
    """`columns` (n, k) low-passed without phase shift at 0.8 of the new Nyquist frequency, one row kept in `factor`.

    An eighth-order Chebyshev filter of 0.05 dB, as Matlab's decimate. Raises ExcitationError on too few rows.
    """
    if factor == 1:
        return columns
    sections = signal.cheby1(8, 0.05, 0.8 / factor, output="sos")
    return _forward_backward(sections, columns, f"the decimation by {factor}")[::factor]
