"""From the motion at every tick of the drive to what a recording holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Floats = NDArray[np.float64]
EFFORTS = ("command", "mean", "delivered")


@dataclass(frozen=True)
class Chain:
    """How a motion is recorded.

    Encoder steps and phases (in counts) of motor and link; `effort` one of `EFFORTS`; noise relative to the rms of the
    torque; `lag_hz` the cut-off of a first-order lag of the effort, 0 for none; delay of the effort and skew of the
    link encoder in samples.
    """

    motor_step: float
    link_step: float
    motor_phase: float
    link_phase: float
    effort: str
    noise: float
    lag_hz: float = 0.0
    delay_samples: float = 0.0
    skew_samples: float = 0.0


@dataclass(frozen=True)
class Recorded:
    """Signals as a recording holds them, all (n,): rad and N m."""

    rate_hz: float
    motor_position: Floats
    link_position: Floats
    motor_torque: Floats


def rounded(position: Floats, step: float, phase: float) -> Floats:
    """Position as an encoder of `step`, rad, gives it."""
    return (np.floor(position / step + phase) - phase + 0.5) * step


def shifted(values: Floats, ticks: float) -> Floats:
    """The same signal `ticks` later."""
    at = np.arange(values.size, dtype=np.float64)
    return np.interp(at - ticks, at, values) if ticks else values


def lagged(values: Floats, rate_hz: float, cutoff_hz: float) -> Floats:
    """The same signal, held between its samples, behind a lag of first order."""
    if cutoff_hz <= 0.0:
        return values
    share = 1.0 - np.exp(-2.0 * np.pi * cutoff_hz / rate_hz)
    filtered = lfilter([0.0, share], [1.0, share - 1.0], values - values[0])
    return np.asarray(filtered) + values[0]


def recorded(ticks: Floats, ratio: int, tick_s: float, chain: Chain, rng: np.random.Generator) -> Recorded:
    """One recording of the integrators' (n, 6) at every `ratio`-th tick."""
    rate = 1.0 / (tick_s * ratio)
    if chain.effort == "mean":  # of the sample that ends
        fine = ticks[:, 3]
        if chain.lag_hz > 0.0:
            after = lagged(fine, 1.0 / tick_s, chain.lag_hz)
            fine = 0.5 * (after + np.append(after[1:], after[-1]))
        total = np.concatenate(([0.0], np.cumsum(fine)))
        end = np.arange(0, ticks.shape[0], ratio) - chain.delay_samples * ratio
        at = np.arange(total.size, dtype=np.float64)
        effort = (np.interp(end, at, total) - np.interp(end - ratio, at, total)) / ratio
        effort[end < ratio] = ticks[0, 3]
    else:
        fine = ticks[:, 2] if chain.effort == "command" else ticks[:, 4]
        fine = lagged(fine, 1.0 / tick_s, chain.lag_hz)
        effort = shifted(fine, chain.delay_samples * ratio)[::ratio]
    link = shifted(ticks[:, 1], chain.skew_samples * ratio)[::ratio]
    effort = effort + chain.noise * np.std(effort) * rng.standard_normal(effort.size)
    return Recorded(
        rate, rounded(ticks[::ratio, 0], chain.motor_step, chain.motor_phase),
        rounded(link, chain.link_step, chain.link_phase), effort,
    )  # fmt: skip
