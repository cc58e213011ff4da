"""What has changed in series of one parameter's values, recording by recording, and how surely over many series.

In a series the values before and after a step scatter about two means. Where the step is is not known: each place
behind the baseline is tried, and the chance of the best is multiplied by how many were tried. How much recordings
scatter is known badly from few of them: the variance of each series is drawn to that of all series, as much as these
have it in common (Smyth 2004, Statistical Applications in Genetics and Molecular Biology 3(1)), and it is never less
than what the results state of themselves. Over all series chances are adjusted by Benjamini and Hochberg (1995).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import digamma, polygamma, stdtr, stdtrit

from flex_ident.pooling.thresholds import FEWEST_PAIRS, FEWEST_TO_SHARE_SCATTER
from flex_ident.recording.recording import Floats, read_only

UNKNOWN_SCATTER = 0.0
MEDIAN_OF_SQUARE, MEDIAN_EFFICIENCY = 0.4549, 0.37
"""Median of the square of a standard normal, and the share of the values that would tell its variance as well."""
FOUND = 0.95
"""Share of the changes of the smallest size that are found."""
CAUTION = 2.0
"""Standard errors by which series are taken to differ more in their scatter than they seem to."""


@dataclass(frozen=True)
class Series:
    """Values (n,) of one parameter in the order of their recordings, with standard deviations (n,) that each states.

    The first `baseline` belong together; from there on a step may be. It is measured in `scale`; 0: in what is
    typically stated of it. Raises ValueError where they do not fit.
    """

    values: Floats
    stds: Floats
    baseline: int
    scale: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", read_only(self.values, name="values"))
        object.__setattr__(self, "stds", read_only(self.stds, name="stds", length=self.values.size))
        if not 1 <= self.baseline < self.values.size or not bool(np.all(self.stds > 0.0)):
            raise ValueError("a series needs a baseline, a value behind it, and stds above 0")

    @cached_property
    def unit(self) -> float:
        """What the series is measured in."""
        return self.scale or float(np.median(self.stds))

    @cached_property
    def stated(self) -> float:
        """The variance that is typically stated, in units squared: that of the series is never taken to be less."""
        return float(np.median(self.stds) / self.unit) ** 2

    @property
    def by_size(self) -> Series:
        """The same, measured in the size of its values: as scatter goes that is a share of them in all series."""
        return replace(self, scale=float(np.median(np.abs(self.values))))

    @cached_property
    def weights(self) -> Floats:
        """Weights (n,) by what each states and what all scatter by: about 1 for what is typical."""
        z, k = self.values / self.unit, self.baseline
        within = float(np.sum(np.square(z[:k] - z[:k].mean())) + np.sum(np.square(z[k:] - z[k:].mean())))
        stated = np.square(self.stds / self.unit)
        scatter = max(0.0, within / max(1, z.size - 2) - float(np.mean(stated)))
        weights: Floats = (scatter + self.stated) / (scatter + np.maximum(stated, self.stated))
        return weights


@dataclass(frozen=True)
class Scatter:
    """What all series have in common of their variance, in their units squared.

    It counts as so many degrees of `freedom`: 0 where nothing is known.
    """

    variance: float = 1.0
    freedom: float = UNKNOWN_SCATTER


@dataclass(frozen=True)
class Step:
    """A step of a series: the first value behind it is number `at`; `std` is that of `after - before`.

    `chance` is that of as large a step by scatter alone anywhere behind the baseline; `freedom` Student's.
    """

    at: int
    before: float
    after: float
    std: float
    freedom: float
    chance: float

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the change, its place taken as known."""
        half = self.std * float(stdtrit(self.freedom, 0.975))
        return self.after - self.before - half, self.after - self.before + half


def common_scatter(series: Sequence[Series]) -> Scatter:
    """What the series have in common of their variance within baseline and rest; nothing is known from a few."""
    usable = [s for s in series if s.values.size > 2]
    if len(usable) < FEWEST_TO_SHARE_SCATTER:
        return _scatter_of_pairs([s for s in series if s.values.size == 2])
    freedom = np.array([s.values.size - 2.0 for s in usable])
    variance = np.array([_split(s, np.array([s.baseline])).variance[0] for s in usable])
    e = np.log(np.maximum(variance, 1e-12)) - digamma(freedom / 2) + np.log(freedom / 2)
    apart = np.square(e - np.mean(e))
    most_apart = float(np.mean(apart)) + CAUTION * float(np.std(apart, ddof=1)) / math.sqrt(len(usable))
    spread = most_apart - float(np.mean(polygamma(1, freedom / 2)))
    most = float(freedom.sum())
    own = most if spread <= 0.0 else min(most, 2.0 * _trigamma_inverse(spread))
    return Scatter(math.exp(float(np.mean(e)) + float(digamma(own / 2)) - math.log(own / 2)), own)


def _scatter_of_pairs(pairs: Sequence[Series]) -> Scatter:
    """What series of two values have in common of their variance, most of them taken to be unchanged: by the median of
    the squared differences, which a few that did change hardly move, and which a third of as many would tell as well.
    """
    if len(pairs) < FEWEST_PAIRS:
        return Scatter()
    squares = []
    for s in pairs:
        split = _split(s, np.array([1]))
        squares.append(float((split.after[0] - split.before[0]) ** 2 / split.spread[0]))
    return Scatter(float(np.median(squares)) / MEDIAN_OF_SQUARE, MEDIAN_EFFICIENCY * len(pairs))


def step(series: Series, scatter: Scatter, *, newest: bool = False) -> Step | None:
    """The likeliest step of a series that two values or more lie behind; or, `newest`, that of the last value alone.

    None where there is none, or nothing says how much recordings scatter. One value alone may be an outlier.
    """
    n = series.values.size
    own = max(0, n - 2)
    freedom = own + scatter.freedom
    at = np.array([n - 1]) if newest else np.arange(series.baseline, n - 1)
    if freedom < 1.0 or not at.size:
        return None
    split = _split(series, at)
    variance = np.maximum(series.stated, (scatter.freedom * scatter.variance + own * split.variance) / freedom)
    std = np.sqrt(variance * split.spread)
    chance = 2.0 * stdtr(freedom, -np.abs(split.after - split.before) / std)
    best = int(np.argmin(chance))
    unit = series.unit
    return Step(
        int(at[best]), unit * float(split.before[best]), unit * float(split.after[best]), unit * float(std[best]),
        freedom, min(1.0, at.size * float(chance[best])),
    )  # fmt: skip


def smallest(series: Series, scatter: Scatter, chance: float) -> float:
    """The smallest step that this series could have shown: found in 95 % where its chance must be under `chance`.

    At the place that shows it best, with two values behind it or more. Infinite where nothing can be told.
    """
    n = series.values.size
    own = max(0, n - 2)
    freedom = own + scatter.freedom
    at = np.arange(series.baseline, n - 1) if n > 2 else np.array([n - 1])
    if freedom < 1.0 or not at.size:
        return math.inf
    split = _split(series, at)
    variance = np.maximum(series.stated, (scatter.freedom * scatter.variance + own * split.variance) / freedom)
    reach = float(stdtrit(freedom, 1.0 - chance / (2.0 * at.size))) + float(stdtrit(freedom, FOUND))
    return series.unit * reach * float(np.min(np.sqrt(variance * split.spread)))


def adjusted(chances: Sequence[float]) -> list[float]:
    """Chances, adjusted so that among those under a rate no more than that share is false on average.

    Benjamini and Hochberg (1995): right where the chances are independent or rise and fall together.
    """
    p = np.array(chances, dtype=float)
    if not p.size:
        return []
    order = np.argsort(p)[::-1]
    ranks = np.arange(p.size, 0, -1)
    result = np.empty(p.size)
    result[order] = np.minimum(1.0, np.minimum.accumulate(p[order] * p.size / ranks))
    return [float(x) for x in result]


@dataclass(frozen=True)
class _Splits:
    """Of each place (m,) of a step: weighted means before and after, variance within, sum of both means' variances."""

    before: Floats
    after: Floats
    variance: Floats
    spread: Floats


def _split(series: Series, at: np.ndarray) -> _Splits:
    z = series.values / series.unit
    centre = float(np.mean(z))
    w, z = series.weights, z - centre
    sums = [np.concatenate(([0.0], np.cumsum(w * z**power))) for power in (0, 1, 2)]
    first = [s[at] for s in sums]
    rest = [s[-1] - s[at] for s in sums]
    before, after = first[1] / first[0], rest[1] / rest[0]
    within = sums[2][-1] - first[0] * before**2 - rest[0] * after**2
    variance = np.maximum(0.0, within) / max(1, series.values.size - 2)
    return _Splits(before + centre, after + centre, variance, 1.0 / first[0] + 1.0 / rest[0])


def _trigamma_inverse(value: float) -> float:
    """The x at which the trigamma function is `value`, by Newton's method (Smyth 2004, appendix)."""
    x = 0.5 + 1.0 / value
    for _ in range(50):
        own = float(polygamma(1, x))
        change = own * (1.0 - own / value) / float(polygamma(2, x))
        x += change
        if abs(change) < 1e-8 * x:
            break
    return x
