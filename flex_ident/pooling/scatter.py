"""How much values scatter from one session to the next, as far as the series of a fleet have it in common.

How much one series scatters is known badly from few values: its variance is drawn to that of all, as much as these have
it in common (Smyth 2004, Statistical Applications in Genetics and Molecular Biology 3(1)). Variances of n degrees of
freedom about one that differs between series like 1 / chi-square of d follow Fisher's F(n, d). The least d that the
fleet allows is taken (one standard error), and d is never more than what so many series tell: what joints share on a
day (the temperature of the hall, the mounting of a robot) makes of many series few.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import betaln

from flex_ident.pooling.series import Series, split
from flex_ident.pooling.thresholds import FEWEST_PAIRS, FEWEST_TO_SHARE_SCATTER, HETEROGENEITY_CAUTION
from flex_ident.recording.recording import Floats

UNKNOWN_SCATTER = 0.0
MEDIAN_OF_SQUARE, MEDIAN_EFFICIENCY = 0.4549, 0.37
"""Median of the square of a standard normal, and the share of the values that would tell its variance as well."""
FREEDOMS = np.geomspace(0.5, 2000.0, 25)
"""Degrees of freedom that are tried for how unlike series scatter; the last is as good as not at all."""
SCALES = np.arange(-8.0, 8.25, 0.5)
"""Logarithms of the common variance that are tried, about the median of the series' own."""
LEAST_VARIANCE = 1e-12
"""Under any variance of values that were measured, in stated variances."""


@dataclass(frozen=True)
class Scatter:
    """What all series have in common of their variance, in their units squared.

    It counts as so many degrees of `freedom`: 0 where nothing is known.
    """

    variance: float = 1.0
    freedom: float = UNKNOWN_SCATTER


def common_scatter(series: Sequence[Series]) -> Scatter:
    """What the series have in common of their variance within baseline and rest; nothing is known from a few."""
    usable = [s for s in series if s.values.size > 2]
    if len(usable) < FEWEST_TO_SHARE_SCATTER:
        return scatter_of_pairs([s for s in series if s.values.size == 2])
    freedom = np.array([s.values.size - 2.0 for s in usable])
    variance = np.array([split(s, np.array([s.baseline])).variance[0] for s in usable])
    count = effective_count(usable, [_residuals(s) for s in usable])
    most = float(freedom.mean()) * (count - 1.0)  # of the others than the one that is judged
    likelihood, log_scale = _likelihoods(np.maximum(variance, LEAST_VARIANCE), freedom)
    likelihood *= count / len(usable)
    least = int(np.argmax(likelihood >= likelihood.max() - HETEROGENEITY_CAUTION))
    own = min(most, float(FREEDOMS[least]))
    return Scatter(float(np.exp(log_scale[least])), own) if own > 0.0 else Scatter()


def _likelihoods(variance: Floats, freedom: Floats) -> tuple[Floats, Floats]:
    """Of each of `FREEDOMS` the log-likelihood of the variances (m,) at the best scale, and that scale's logarithm."""
    centre = float(np.log(np.median(variance)))
    log_ratio = np.log(variance) - centre
    best, scales = np.empty(FREEDOMS.size), np.empty(FREEDOMS.size)
    for i, d in enumerate(FREEDOMS):
        found = _log_f(log_ratio, freedom, float(d), SCALES)
        at = int(np.clip(np.argmax(found), 1, SCALES.size - 2))
        low, middle, high = found[at - 1 : at + 2]
        curvature = min(low + high - 2.0 * middle, -1e-12)
        shift = float(np.clip(0.5 * (low - high) / curvature, -1.0, 1.0))  # the top of a parabola through the three
        best[i] = middle - 0.25 * (low - high) * shift
        scales[i] = centre + SCALES[at] + shift * (SCALES[1] - SCALES[0])
    return best, scales


def _log_f(log_variance: Floats, freedom: Floats, d: float, log_scales: Floats) -> Floats:
    """Log-likelihood (k) of logarithms (m,) of variances whose ratio to each scale (k) follows Fisher's F."""
    x = log_variance - log_scales[:, None]
    half = 0.5 * freedom
    terms = half * (np.log(freedom / d) + x) - (half + 0.5 * d) * np.log1p(freedom / d * np.exp(x))
    found: Floats = np.sum(terms - betaln(half, 0.5 * d), axis=1)
    return found


def scatter_of_pairs(pairs: Sequence[Series]) -> Scatter:
    """What series of two values have in common of their variance, most of them taken to be unchanged: by the median of
    the squared differences, which a few that did change hardly move, and which a third of as many would tell as well.
    """
    if len(pairs) < FEWEST_PAIRS:
        return Scatter()
    apart = []
    for s in pairs:
        both = split(s, np.array([1]))
        apart.append(float((both.after[0] - both.before[0]) / np.sqrt(both.spread[0])))
    count = effective_count(pairs, [np.array([0.0, own]) for own in apart])
    return Scatter(float(np.median(np.square(apart))) / MEDIAN_OF_SQUARE, MEDIAN_EFFICIENCY * count)


def effective_count(series: Sequence[Series], residuals: Sequence[Floats]) -> float:
    """As many independent series would tell a common variance as well as these, whose `residuals` (n,) go together.

    A variance from m series whose residuals are correlated by r is as good as one from m / (1 + (m - 1) r^2). How much
    they are is taken from the signs on the same days: within groups, and between them.
    """
    m = len(series)
    tables: dict[tuple[str, int], list[float]] = {}
    for s, own in zip(series, residuals, strict=True):
        for day, r in zip(s.days, own, strict=True):
            tables.setdefault((s.group, day), []).append(float(r))
    within, everywhere = _Shared(), _Shared()
    by_day: dict[int, list[float]] = {}
    for (_, day), left in tables.items():
        within.add(np.array(left))
        by_day.setdefault(day, []).extend(left)
    for left in by_day.values():
        everywhere.add(np.array(left))
    size = float(np.mean([s.values.size for s in series]))
    others = _Shared(everywhere.cross - within.cross, everywhere.most - within.most, everywhere.pairs - within.pairs)
    together = (within.pairs * within.correlation**2 + others.pairs * others.correlation**2) / size
    return m * m / (m + together)


@dataclass
class _Shared:
    """Sums over pairs of residuals of one day: of their products, of what these are at most, and how many there are."""

    cross: float = 0.0
    most: float = 0.0
    pairs: float = 0.0

    def add(self, day: Floats) -> None:
        """Add the residuals (m,) of one day."""
        square = float(day @ day)
        self.cross += float(day.sum()) ** 2 - square
        self.most += float(np.abs(day).sum()) ** 2 - square
        self.pairs += day.size * (day.size - 1.0)

    @property
    def correlation(self) -> float:
        """How alike the residuals are, 0 to 1."""
        return min(1.0, max(0.0, self.cross / self.most)) if self.most > 0.0 else 0.0


def _residuals(s: Series) -> Floats:
    """What is left (n,) of the values about the means of baseline and rest, in units."""
    both = split(s, np.array([s.baseline]))
    z = s.values / s.unit
    found: Floats = np.concatenate((z[: s.baseline] - both.before[0], z[s.baseline :] - both.after[0]))
    return found
