"""What is compared of a fleet: each parameter of each joint as a series of sessions, measured alike over the fleet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtr

from flex_ident.fleet.history import History, Told
from flex_ident.pooling.changes import Step
from flex_ident.pooling.scatter import Scatter, common_scatter, scatter_of_pairs
from flex_ident.pooling.series import Series, split
from flex_ident.pooling.sessions import session_means
from flex_ident.pooling.thresholds import FEW_DAYS, FEWEST_TO_SHARE_SCATTER

DAY_S = 86400.0


@dataclass(frozen=True)
class Compared:
    """One parameter of one joint: its series of sessions, and of each session which results of the history it is of."""

    history: History
    key: str
    unit: str
    series: Series
    sessions: tuple[tuple[int, ...], ...]

    @property
    def name(self) -> tuple[str, ...]:
        """What it is of."""
        return (*self.history.name, self.key, self.unit)

    @property
    def places(self) -> tuple[int, ...]:
        """The results of the history that it is of."""
        return tuple(i for own in self.sessions for i in own)

    def told(self, first: int, end: int | None = None) -> list[Told]:
        """The results of the sessions from number `first` until `end`."""
        return [self.history.results[i] for own in self.sessions[first:end] for i in own]


def comparisons(history: History) -> list[Compared]:
    """A series for each parameter and unit that a session of the baseline and a later one determine."""
    before = history.results[: history.baseline]
    found = []
    for key, unit in dict.fromkeys((k, p[2]) for told in before for k, p in told.parameters.items()):
        which = [i for i, t in enumerate(history.results) if key in t.parameters and t.parameters[key][2] == unit]
        numbers = [history.sessions[i] for i in which]
        count = len({s for s, i in zip(numbers, which, strict=True) if i < history.baseline})
        sessions = tuple(
            tuple(i for i, s in zip(which, numbers, strict=True) if s == own) for own in sorted(set(numbers))
        )
        if count == len(sessions):
            continue
        values, stds = (np.array([history.results[i].parameters[key][j] for i in which], dtype=float) for j in (0, 1))
        means, mean_stds, _ = session_means(values, stds, numbers)
        days = tuple(int(history.results[own[0]].at.timestamp() // DAY_S) for own in sessions)
        series = Series(means, mean_stds, count, days=days, group=history.robot)
        found.append(Compared(history, key, unit, series, sessions))
    return found


def measured(compared: Sequence[Compared]) -> tuple[list[Compared], dict[str, Scatter]]:
    """The series in what makes their scatter most alike over the fleet, and what they then have in common of it.

    Parameter by parameter: in what each result states of itself, or in shares of the value, whichever leaves more in
    common. Recordings that are known unequally well scatter alike where scatter is not of the fit but of the joint.
    """
    found: list[Compared] = []
    scatter: dict[str, Scatter] = {}
    by_key: dict[str, list[Compared]] = {}
    for c in compared:
        by_key.setdefault(c.key, []).append(c)
    for key, own in by_key.items():
        scatter[key] = common_scatter([c.series for c in own])
        if all(np.median(np.abs(c.series.values)) > 0.0 for c in own):
            shares = [replace(c, series=c.series.by_size) for c in own]
            other = common_scatter([c.series for c in shares])
            if other.freedom > scatter[key].freedom:
                own, scatter[key] = shares, other
        found += own
    return found, scatter


def as_pairs(compared: Sequence[Compared]) -> dict[tuple[str, ...], tuple[Series, Scatter]]:
    """The series of three sessions as such of two, with the scatter that pairs have: three tell no less than two do."""
    pairs: dict[str, list[tuple[tuple[str, ...], Series]]] = {}
    for c in compared:
        if c.series.values.size == 3:
            pairs.setdefault(c.key, []).append((c.name, c.series.as_pair))
    scatter = {key: scatter_of_pairs([series for _, series in own]) for key, own in pairs.items()}
    return {name: (series, scatter[key]) for key, own in pairs.items() for name, series in own}


def apart_from_all(steps: Sequence[tuple[Compared, Step]]) -> list[tuple[Compared, Step]]:
    """The steps; those of few sessions no surer than what tells them from the fleet's own.

    Of few days those on one side are alike by luck often enough, and what the fleet then shares (a warm hall) passes
    for a step of every joint. More days show how much days differ.
    """
    alike: dict[tuple[str, int, int], list[Compared]] = {}
    for c, _ in steps:
        alike.setdefault((c.key, c.series.values.size, c.series.baseline), []).append(c)
    shared: dict[tuple[str, int, int, int], float] = {}
    result = []
    for c, found in steps:
        own = (c.key, c.series.values.size, c.series.baseline)
        if c.series.values.size <= FEW_DAYS and len(alike[own]) >= FEWEST_TO_SHARE_SCATTER:
            if (*own, found.at) not in shared:
                shared[*own, found.at] = _median_step([other.series for other in alike[own]], found.at)
            apart = abs(found.after - found.before - shared[*own, found.at] * c.series.unit) / found.std
            found = replace(found, chance=max(found.chance, min(1.0, 2.0 * float(stdtr(found.freedom, -apart)))))
        result.append((c, found))
    return result


def _median_step(series: Sequence[Series], at: int) -> float:
    """The median of the steps at one place, in units."""
    sides = [split(own, np.array([at])) for own in series]
    return float(np.median([own.after[0] - own.before[0] for own in sides]))
