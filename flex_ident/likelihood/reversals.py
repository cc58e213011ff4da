"""Reversals: while the motor stands still between two directions, dry friction takes any value and says nothing.

For how long it stands still only the encoder tells, and an encoder cannot tell standstill from creeping. So friction
is taken as unknown there: over each short stretch of standstill it adds noise of a known shape to the torque, and
residuals are weighted by the covariance that this gives. Otherwise a motor that sticks for some milliseconds looks like
a missing effect of friction.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from flex_ident.filtering.spectral import lowpass_response
from flex_ident.likelihood.problem import DRIVE_MARGIN, FitProblem, terms_of
from flex_ident.likelihood.whitening import Whitening
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.response import standstill_friction

STANDSTILL = 1.5
"""Velocity, relative to what the recording resolves, under which the direction counts as unknown."""
ROUNDING = 0.5
"""Share of the velocity's kink at a reversal, as the low-pass on the position rounds it off, that counts likewise."""
AROUND_S = 0.02
AUDIBLE = 0.4
"""Size of a mark on the whitened residual, standard deviations, from which it is worth keeping."""
REACH_PERIODS = 1.8
"""Periods of the cutoff by which the low-pass spreads a mark."""
MOST_TOGETHER = 120
"""Marks that are weighted together; a longer chain of overlapping marks is cut."""


@dataclass(frozen=True)
class Mark:
    """What friction of 1 N m over one stretch adds to the torque: `shape` (s,) from sample `first` on."""

    first: int
    shape: Floats


@dataclass(frozen=True)
class Cluster:
    """Marks whose whitened forms W overlap: `whitened` (s, k) from row `first` on, `inverse` (k, k) of I + W' W.

    `directions` (s, j) are orthonormal, `shares` (j,) what the root of the inverse covariance takes off each.
    """

    marks: tuple[Mark, ...]
    first: int
    whitened: Floats
    inverse: Floats
    directions: Floats
    shares: Floats


def dry_friction(values: Values) -> float:
    """Size of the motor's dry friction at standstill, N m, under the values."""
    return standstill_friction(terms_of(values, rigid="J" in values))


def _stretches(problem: FitProblem) -> NDArray[np.int64]:
    """First and last + 1 (k, 2) of the recording's samples in which the direction of motion is unknown."""
    motion, rate = problem.motion, problem.recording.sample_rate_hz
    around = ndimage.maximum_filter1d(np.abs(motion.acceleration), 2 * round(AROUND_S * rate) + 1)
    rounded = ROUNDING * around / (2.0 * np.pi * DRIVE_MARGIN * problem.band_hz)
    resting = max(STANDSTILL * problem.resolution, problem.resting_speed)
    return _runs(np.abs(motion.velocity) < np.maximum(resting, rounded))


def _runs(marked: NDArray[np.bool_]) -> NDArray[np.int64]:
    """First and last + 1 (k, 2) of each run of marked samples (n,)."""
    return np.flatnonzero(np.diff(np.concatenate(([0], marked.astype(np.int8), [0])))).reshape(-1, 2)


def standstills(problem: FitProblem) -> list[tuple[int, int]]:
    """Stretches (first, last + 1) of the recording's samples in which the direction of motion is unknown.

    A long one is cut into pieces that the comparison's low-pass can tell apart. Where samples are further apart than
    that low-pass's time, with the samples beside, between which and the first or the last a rest begins or ends:
    without them FSm of an adversary's clean joint was 2 % high at 250 Hz. With them at all rates errors of clean joints
    at 500 Hz and more were larger (`bench/coverage.py`, seed 509, 24 recordings).
    """
    rate, stretches = problem.recording.sample_rate_hz, _stretches(problem)
    if rate < 2.0 * np.pi * problem.cutoff_hz:
        stretches = _with_neighbours(stretches, problem.recording.motor_position.size)
    longest = max(1, round(0.5 * rate / problem.cutoff_hz))
    pieces = []
    for first, last in stretches:
        count = max(1, round((last - first) / longest))
        cuts = np.linspace(first, last, count + 1).round().astype(int)
        pieces += [(int(a), int(b)) for a, b in pairwise(cuts) if b > a]
    return pieces


def _with_neighbours(stretches: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Stretches (k, 2) with a sample more at each end, of `count`; those that meet then are one."""
    inside = np.zeros(count + 1, np.int64)
    np.add.at(inside, np.maximum(stretches[:, 0] - 1, 0), 1)
    np.add.at(inside, np.minimum(stretches[:, 1] + 1, count), -1)
    return _runs(np.cumsum(inside[:-1]) > 0)


def stuck(problem: FitProblem) -> NDArray[np.bool_]:
    """Where (m,) the motor stands still for over a period of the cutoff, and around: friction is unknown there."""
    reach = problem.recording.sample_rate_hz / problem.cutoff_hz
    marked = np.zeros(problem.recording.motor_position.size, bool)
    for first, last in _stretches(problem):
        if last - first > reach:
            marked[max(0, int(first - REACH_PERIODS * reach)) : int(last + REACH_PERIODS * reach) + 1] = True
    return marked[:: problem.decimation]


def friction_marks(problem: FitProblem) -> tuple[Mark, ...]:
    """What an unknown friction of 1 N m adds to the filtered and decimated torque: two marks a stretch.

    One of a friction that is the same over the whole stretch, and one of a friction that turns over evenly along it
    where the model lets it turn over in the middle at once: half of it too little before, and half too much after.
    """
    rate, d = problem.recording.sample_rate_hz, problem.decimation
    reach = max(4, round(REACH_PERIODS / problem.cutoff_hz * problem.rate_hz))
    length = fft.next_fast_len(8 * (reach + 1) * d, real=True)
    impulse = fft.irfft(lowpass_response(fft.rfftfreq(length, 1.0 / rate), problem.cutoff_hz), length)
    answer = np.cumsum(np.roll(impulse, length // 2))  # to a step that begins at length // 2
    places = np.arange(length)
    found = []
    for first, last in standstills(problem):
        begin = max(0, first // d - reach)
        moments = np.arange(begin, min(problem.time.size, last // d + reach + 1)) * d + length // 2
        start, middle, end = (np.interp(moments - at, places, answer) for at in (first, 0.5 * (first + last), last))
        found += [Mark(begin, start - end), Mark(begin, 0.5 * (start - 2.0 * middle + end))]
    return tuple(found)


class ReversalWeights:
    """Takes unknown friction out of whitened torque residuals: multiplies by the symmetric root of (I + W W')^-1.

    The columns of W (r, k) are the whitened marks of a friction of that size, N m; `rows` are the rows of the
    decimated clock that residuals keep.
    """

    def __init__(self, marks: tuple[Mark, ...], friction: float, whitening: Whitening, rows: NDArray[np.int64]) -> None:
        self._friction = friction
        self._clusters: list[Cluster] = []
        together: list[tuple[Mark, int, Floats]] = []
        end = -1
        for mark, filtered in zip(marks, _whitened_marks(marks, whitening), strict=True):
            low, high = np.searchsorted(rows, (mark.first, mark.first + filtered.size))
            whitened = friction * filtered[rows[low:high] - mark.first]
            if float(whitened @ whitened) < AUDIBLE**2:
                continue
            if together and (low >= end or len(together) >= MOST_TOGETHER):
                self._clusters.append(_cluster(together))
                together = []
            together.append((mark, int(low), whitened))
            end = max(end, int(high))
        if together:
            self._clusters.append(_cluster(together))

    def __call__(self, whitened: Floats) -> Floats:
        """Whitened torque residuals, (r,) or (r, k), with less weight on what unknown friction can do."""
        result = whitened.copy()
        for c in self._clusters:
            part = result[c.first : c.first + c.directions.shape[0]]
            part -= c.directions @ (c.shares * (c.directions.T @ part).T).T
        return result

    def friction(self, whitened: Floats, size: int) -> Floats:
        """The torque (size,), N m, that unknown friction most probably took, from whitened residuals (r,)."""
        torque = np.zeros(size)
        for c in self._clusters:
            part = whitened[c.first : c.first + c.whitened.shape[0]]
            for mark, amount in zip(c.marks, c.inverse @ (c.whitened.T @ part), strict=True):
                torque[mark.first : mark.first + mark.shape.size] += self._friction * amount * mark.shape
        return torque


def _whitened_marks(marks: tuple[Mark, ...], whitening: Whitening) -> list[Floats]:
    """Each mark behind the whitening filter, with the tail that this makes, all filtered side by side."""
    if not marks:
        return []
    sizes = [mark.shape.size for mark in marks]
    padded = np.zeros((max(sizes) + whitening.memory, len(marks)))
    for i, mark in enumerate(marks):
        padded[: sizes[i], i] = mark.shape
    filtered = whitening(padded)
    return [filtered[: size + whitening.memory, i] for i, size in enumerate(sizes)]


def _cluster(together: list[tuple[Mark, int, Floats]]) -> Cluster:
    first = min(low for _, low, _ in together)
    last = max(low + whitened.size for _, low, whitened in together)
    columns = np.zeros((last - first, len(together)))
    for column, (_, low, whitened) in zip(columns.T, together, strict=True):
        column[low - first : low - first + whitened.size] = whitened
    squares, vectors = np.linalg.eigh(columns.T @ columns)
    inverse = (vectors / (1.0 + squares)) @ vectors.T
    kept = squares > AUDIBLE**2
    directions = columns @ (vectors[:, kept] / np.sqrt(squares[kept]))
    shares = 1.0 - 1.0 / np.sqrt(1.0 + squares[kept])
    return Cluster(tuple(mark for mark, _, _ in together), first, columns, inverse, directions, shares)
