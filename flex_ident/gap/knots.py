"""Where the points of a measured curve lie: few, closer together where the law may bend most, none without data."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flex_ident.gap.thresholds import CURVE_EDGE, CURVE_SECONDS
from flex_ident.likelihood.problem import FitProblem
from flex_ident.recording import Floats

CLOSER = 1.5
"""Power of the points' spacing away from zero: friction bends most where it is slow, a spring around zero."""


def points_to_both_sides(problem: FitProblem, values: Floats, count: int, least: float = 0.0) -> Floats:
    """Points (k,), at most `count` to each side of zero and none within `least` of it, of `values` (n,) of the
    recording's samples: each with time of its own around it."""
    there = values[_kept(problem)]
    sides = []
    for sign in (-1.0, 1.0):
        size = sign * there[sign * there > least]
        if size.size < 2:
            continue
        largest = float(np.quantile(size, 1.0 - CURVE_EDGE))
        steps: Floats = np.linspace(0.5 / (count - 0.5), 1.0, count)
        sides.append(np.sort(sign * _held(largest * steps**CLOSER, size, problem)))
    return np.concatenate(sides) if sides else np.zeros(0)


def range_points(problem: FitProblem, values: Floats, count: int) -> Floats:
    """Points (k,), at most `count`, evenly over the range that `values` (n,) of the recording's samples run through."""
    there = values[_kept(problem)]
    low, high = np.quantile(there, (CURVE_EDGE, 1.0 - CURVE_EDGE))
    return _held(np.linspace(low, high, count), there, problem) if high > low else np.zeros(0)


def _kept(problem: FitProblem) -> NDArray[np.bool_]:
    """The recording's samples that are compared, as a mask (n,)."""
    n = problem.motion.velocity.size
    mask = np.repeat(problem.usable, problem.decimation)[:n]
    return np.concatenate((mask, np.zeros(n - mask.size, bool)))


def _held(points: Floats, values: Floats, problem: FitProblem) -> Floats:
    """Those of increasing points (k,) around which `values` lie for long enough, the first left out first."""
    least = CURVE_SECONDS * problem.recording.sample_rate_hz
    kept = points
    while kept.size >= 2:
        edges = np.concatenate(([-np.inf], 0.5 * (kept[1:] + kept[:-1]), [np.inf]))
        few = np.flatnonzero(np.histogram(values, edges)[0] < least)
        if not few.size:
            return kept
        kept = np.delete(kept, few[0])
    return np.zeros(0)
