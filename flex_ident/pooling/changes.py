"""What has changed in series of one parameter's values, session by session, and how surely over many series.

In a series the values before and after a step scatter about two means. Where the step is is not known: each place
behind the baseline is tried, and the chance of the best is multiplied by how many were tried. How much values scatter
is known from the series and from the fleet (`scatter.py`), and is never less than what they state of themselves. Over
all series chances are adjusted by Benjamini and Hochberg (1995).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr, stdtrit

from flex_ident.pooling.scatter import Scatter
from flex_ident.pooling.series import Series, split
from flex_ident.pooling.thresholds import FEWEST_DEGREES

FOUND = 0.95
"""Share of the changes of the smallest size that are found."""


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


def step(series: Series, scatter: Scatter, *, newest: bool = False) -> Step | None:
    """The likeliest step of a series that two values or more lie behind; or, `newest`, that of the last value alone.

    None where there is none, or nothing says how much recordings scatter. One value alone may be an outlier.
    """
    n = series.values.size
    own = max(0, n - 2)
    freedom = own + scatter.freedom
    at = np.array([n - 1]) if newest else np.arange(series.baseline, n - 1)
    if freedom < FEWEST_DEGREES or not at.size:
        return None
    sides = split(series, at)
    variance = np.maximum(series.stated, (scatter.freedom * scatter.variance + own * sides.variance) / freedom)
    std = np.sqrt(variance * sides.spread)
    chance = 2.0 * stdtr(freedom, -np.abs(sides.after - sides.before) / std)
    best = int(np.argmin(chance))
    unit = series.unit
    return Step(
        int(at[best]), unit * float(sides.before[best]), unit * float(sides.after[best]), unit * float(std[best]),
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
    if freedom < FEWEST_DEGREES or not at.size:
        return math.inf
    sides = split(series, at)
    variance = np.maximum(series.stated, (scatter.freedom * scatter.variance + own * sides.variance) / freedom)
    reach = float(stdtrit(freedom, 1.0 - chance / (2.0 * at.size))) + float(stdtrit(freedom, FOUND))
    return series.unit * reach * float(np.min(np.sqrt(variance * sides.spread)))


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
