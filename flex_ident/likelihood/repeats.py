"""What repeats when the motion repeats is model error; the rest is noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.thresholds import ALIKE
from flex_ident.recording import Floats

SHORTEST_S = 3.0


@dataclass(frozen=True)
class Repeats:
    """Where the recording repeats its motion: what repeats in the residual is model error, the rest is noise, N m."""

    period_s: float
    repeatable: float
    noise: float


def repetition_samples(problem: FitProblem) -> int:
    """Period of the motion on the decimated clock, samples; 0 when it does not repeat."""
    wanted = problem.recording.reference
    signal = problem.motion.position if wanted is None else wanted
    x = signal[:: problem.decimation]
    x = x - x.mean()
    shortest = round(SHORTEST_S * problem.rate_hz)
    longest = x.size // 2 + 1
    if longest <= shortest:
        return 0
    length = 1 << (2 * x.size - 1).bit_length()
    raw = np.fft.irfft(np.abs(np.fft.rfft(x, length)) ** 2, length)[:longest]
    squares = np.concatenate(([0.0], np.cumsum(x * x)))
    lags = np.arange(longest)
    norm = np.sqrt((squares[x.size - lags]) * (squares[-1] - squares[lags]))
    correlation = raw / np.maximum(norm, 1e-300)
    k = shortest + int(np.argmax(correlation[shortest:]))
    # Slow motion resembles itself at any short lag: a period is a peak, not the flank of lag zero.
    inner = correlation[max(1, shortest // 2) : k]
    if correlation[k] < ALIKE or (inner.size and inner.min() > 0.9):
        return 0
    return k


def repeated(problem: FitProblem, residual: Floats, usable: NDArray[np.bool_]) -> Repeats | None:
    """The residual (m,) split into what repeats and what does not; None when the motion does not repeat."""
    lag = repetition_samples(problem)
    if lag == 0:
        return None
    both = usable[lag:] & usable[:-lag]
    if int(both.sum()) < 100:
        return None
    first, second = residual[:-lag][both], residual[lag:][both]
    noise = 0.5 * float(np.mean((first - second) ** 2))
    repeatable = max(0.0, float(np.mean(first * second)))
    return Repeats(lag / problem.rate_hz, math.sqrt(repeatable), math.sqrt(noise))
