"""What has changed in a fleet, each parameter of each joint against its baseline, false alarms held over all."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flex_ident.errors import DataError
from flex_ident.fleet.causes import probable_cause
from flex_ident.fleet.history import History, Told, histories
from flex_ident.fleet.rows import Row
from flex_ident.pooling.changes import Scatter, Series, Step, adjusted, common_scatter, smallest, step
from flex_ident.pooling.thresholds import FALSE_CHANGES

HEALTH = "flex_ident/health/1"
COLUMNS = (
    "robot", "joint", "sha256", "sensors", "verdict", "recorded_at", "finished_at", "tag", "conditions", "parameters",
    "covariance",
)  # fmt: skip
"""What is read of the archive."""
WARMER = 5.0
"""Kelvin by which recordings must differ before a change of friction is put down to it. Set by hand."""


@dataclass(frozen=True)
class _Compared:
    """One parameter of one joint: its series, and the results that it is of."""

    history: History
    key: str
    unit: str
    series: Series
    results: tuple[Told, ...]

    @property
    def name(self) -> tuple[str, ...]:
        """What it is of."""
        return (*self.history.name, self.key, self.unit)


@dataclass(frozen=True)
class Shown:
    """A judged series with its likeliest step, the smallest change it could have shown, and whether one is named."""

    compared: _Compared
    step: Step
    smallest: float
    changed: bool


def fleet_health(rows: Iterable[Row], baseline: str = "") -> dict[str, Any]:
    """The content of `flex_ident health --json` (docs/fleet.md). Raises DataError where nothing can be compared."""
    known = histories(rows, baseline)
    compared = [c for history in known for c in _comparisons(history)]
    compared, scatter = _measured(compared)
    steps = [(c, step(c.series, scatter[c.key])) for c in compared]
    newest = [(c, step(c.series, scatter[c.key], newest=True)) for c in compared]
    judged = [(c, s) for c, s in steps if s is not None]
    if not judged and all(s is None for _, s in newest):
        counted = f"{len(known)} joint, and it has not" if len(known) == 1 else f"{len(known)} joints, and none has"
        raise DataError(
            f"nothing can be compared: {counted} results enough (a change rests on two results behind the baseline, "
            "and how much results scatter on three or more, on five joints, or on twenty with two results each)."
        )
    changes = _significant(judged)
    changed = {c.name for c, _, _ in changes}
    alone = [(c, s) for c, s in newest if s is not None and c.name not in changed]
    to_confirm = _significant(alone)
    told = judged or alone  # of pairs of results the newest alone can be judged
    shown = [
        Shown(c, s, smallest(c.series, scatter[c.key], FALSE_CHANGES / len(told)), c.name in changed) for c, s in told
    ]
    by_history: dict[tuple[str, ...], list[Shown]] = {}
    for one in shown:
        by_history.setdefault(one.compared.history.name, []).append(one)
    return {
        "schema": HEALTH, "baseline": baseline or "first results",
        "false_alarms": {"method": "Benjamini-Hochberg", "rate": FALSE_CHANGES, "comparisons": len(told)},
        "smallest": _smallest(shown),
        "joints": [
            _joint(h, by_history.get(h.name, []), _of(changes, h), _of(to_confirm, h)) for h in known
        ],
        "changes": [_change(*own) for own in changes],
        "to_confirm": [_change(*own) for own in to_confirm],
    }  # fmt: skip


def _comparisons(history: History) -> list[_Compared]:
    """A series for each parameter and unit that a result of the baseline and a later one determine."""
    before = history.results[: history.baseline]
    found = []
    for key, unit in dict.fromkeys((k, p[2]) for told in before for k, p in told.parameters.items()):
        which = [i for i, t in enumerate(history.results) if key in t.parameters and t.parameters[key][2] == unit]
        count = sum(i < history.baseline for i in which)
        if count == len(which):
            continue
        results = tuple(history.results[i] for i in which)
        values, stds = (np.array([told.parameters[key][j] for told in results], dtype=float) for j in (0, 1))
        found.append(_Compared(history, key, unit, Series(values, stds, count), results))
    return found


def _measured(compared: Sequence[_Compared]) -> tuple[list[_Compared], dict[str, Scatter]]:
    """The series in what makes their scatter most alike over the fleet, and what they then have in common of it.

    Parameter by parameter: in what each result states of itself, or in shares of the value, whichever leaves more in
    common. Recordings that are known unequally well scatter alike where scatter is not of the fit but of the joint.
    """
    found: list[_Compared] = []
    scatter: dict[str, Scatter] = {}
    by_key: dict[str, list[_Compared]] = {}
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


_Found = tuple[_Compared, Step, float]
"""A change, and its chance adjusted over all comparisons."""


def _significant(steps: Sequence[tuple[_Compared, Step]]) -> list[_Found]:
    chances = adjusted([s.chance for _, s in steps])
    return [(c, s, p) for (c, s), p in zip(steps, chances, strict=True) if p < FALSE_CHANGES]


def _change(own: _Compared, found: Step, chance: float) -> dict[str, Any]:
    size = abs(found.before)
    low, high = found.interval
    percent = [100.0 * x / size if size > 0.0 else None for x in (found.after - found.before, low, high)]
    return {
        "robot": own.history.robot, "joint": own.history.joint, "model": own.history.model,
        "parameter": own.key, "unit": own.unit,
        "before": {"value": found.before, "results": found.at},
        "after": {"value": found.after, "results": own.series.values.size - found.at},
        "change": found.after - found.before, "ci95": [low, high],
        "change_percent": percent[0], "ci95_percent": percent[1:],
        "chance": chance,
        "since": {"after": own.results[found.at - 1].at.isoformat(), "until": own.results[found.at].at.isoformat()},
    }  # fmt: skip


def _of(changes: Sequence[_Found], history: History) -> dict[str, tuple[_Compared, Step]]:
    """The changes of one joint, by parameter."""
    return {c.key: (c, s) for c, s, _ in changes if c.history is history}


def _joint(
    history: History, shown: Sequence[Shown], changes: Mapping[str, tuple[_Compared, Step]],
    waiting: Mapping[str, tuple[_Compared, Step]],
) -> dict[str, Any]:  # fmt: skip
    """What is said of one joint: changed, or waiting for a second result that says so, with a probable cause;
    unchanged; or not judged; and its series."""
    known = [one.compared.key for one in shown]
    own = changes or waiting
    content: dict[str, Any] = {
        "robot": history.robot, "joint": history.joint, "model": history.model, "results": len(history.results),
        "baseline_results": history.baseline,
        "state": "changed" if changes else "to_confirm" if waiting else "unchanged" if known else "not_judged",
        "recorded_at": [told.at.isoformat() for told in history.results],
        "parameters": {one.compared.key: _parameter(one) for one in shown},
    }  # fmt: skip
    if own:
        sizes = {key: abs(s.before) or 1.0 for key, (_, s) in own.items()}
        relative = {key: ((s.after - s.before) / sizes[key], s.std / sizes[key]) for key, (_, s) in own.items()}
        warmer = any(_warmer(c, s) for c, s in own.values())
        content["cause"] = str(probable_cause(relative, known, temperature=warmer))
    return content


def _parameter(one: Shown) -> dict[str, Any]:
    """A parameter's series, its results by their place in the joint's, and the smallest change that it could show."""
    c, size = one.compared, float(np.median(np.abs(one.compared.series.values)))
    place = {id(told): i for i, told in enumerate(c.history.results)}
    return {
        "unit": c.unit, "values": [float(x) for x in c.series.values], "stds": [float(x) for x in c.series.stds],
        "results": [place[id(told)] for told in c.results], "changed": one.changed,
        "smallest": one.smallest if np.isfinite(one.smallest) else None,
        "smallest_percent": 100.0 * one.smallest / size if size > 0.0 and np.isfinite(one.smallest) else None,
    }  # fmt: skip


def _smallest(shown: Sequence[Shown]) -> dict[str, dict[str, float | int]]:
    """Over the fleet, the smallest change of each parameter that its series could show, in percent: median, worst."""
    found: dict[str, list[float]] = {}
    for one in shown:
        size = float(np.median(np.abs(one.compared.series.values)))
        if size > 0.0 and np.isfinite(one.smallest):
            found.setdefault(one.compared.key, []).append(100.0 * one.smallest / size)
    return {
        key: {"median_percent": float(np.median(own)), "worst_percent": max(own), "series": len(own)}
        for key, own in found.items()
    }


def _warmer(own: _Compared, found: Step) -> bool:
    """Whether the recordings behind the change were made at another temperature, as far as that was written down."""
    first = [t.temperature for t in own.results[: found.at] if t.temperature is not None]
    rest = [t.temperature for t in own.results[found.at :] if t.temperature is not None]
    return bool(first and rest) and abs(float(np.mean(first)) - float(np.mean(rest))) > WARMER
