"""A parameter's values over time, and what lies before and behind each place where they may have stepped."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flex_ident.recording.recording import Floats, read_only


@dataclass(frozen=True)
class Series:
    """Values (n,) of one parameter in the order of their recordings, with standard deviations (n,) that each states.

    The first `baseline` belong together; from there on a step may be. It is measured in `scale`; 0: in what is
    typically stated of it. `days` (n,) tell which values of several series were recorded together, `group` which series
    go together (the joints of a robot). Raises ValueError where they do not fit.
    """

    values: Floats
    stds: Floats
    baseline: int
    scale: float = 0.0
    days: tuple[int, ...] = ()
    group: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", read_only(self.values, name="values"))
        object.__setattr__(self, "stds", read_only(self.stds, name="stds", length=self.values.size))
        if not 1 <= self.baseline < self.values.size or not bool(np.all(self.stds > 0.0)):
            raise ValueError("a series needs a baseline, a value behind it, and stds above 0")
        object.__setattr__(self, "days", self.days or tuple(range(self.values.size)))
        if len(self.days) != self.values.size:
            raise ValueError("a series needs a day for each value")

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

    @property
    def as_pair(self) -> Series:
        """The mean of the baseline and that of the rest, as a series of two."""
        k = self.baseline
        parts = [(self.values[own], self.stds[own]) for own in (slice(0, k), slice(k, None))]
        weights = [1.0 / stds**2 for _, stds in parts]
        values = [float(np.average(x, weights=w)) for (x, _), w in zip(parts, weights, strict=True)]
        stds = [1.0 / float(np.sqrt(w.sum())) for w in weights]
        return replace(
            self, values=np.array(values), stds=np.array(stds), baseline=1, days=(self.days[0], self.days[k])
        )

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
class Splits:
    """Of each place (m,) of a step: weighted means before and after, variance within, sum of both means' variances."""

    before: Floats
    after: Floats
    variance: Floats
    spread: Floats


def split(series: Series, at: np.ndarray) -> Splits:
    """Means and scatter before and behind each place `at` (m,)."""
    z = series.values / series.unit
    centre = float(np.mean(z))
    w, z = series.weights, z - centre
    sums = [np.concatenate(([0.0], np.cumsum(w * z**power))) for power in (0, 1, 2)]
    first = [s[at] for s in sums]
    rest = [s[-1] - s[at] for s in sums]
    before, after = first[1] / first[0], rest[1] / rest[0]
    within = sums[2][-1] - first[0] * before**2 - rest[0] * after**2
    variance = np.maximum(0.0, within) / max(1, series.values.size - 2)
    return Splits(before + centre, after + centre, variance, 1.0 / first[0] + 1.0 / rest[0])
