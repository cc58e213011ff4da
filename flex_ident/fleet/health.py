"""What has changed in a fleet, each parameter of each joint against its baseline, false alarms held over all."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flex_ident.errors import DataError
from flex_ident.fleet.causes import Cause, probable_cause
from flex_ident.fleet.comparing import Compared, apart_from_all, as_pairs, comparisons, measured
from flex_ident.fleet.history import History, histories
from flex_ident.fleet.replaced import without_replaced
from flex_ident.fleet.rows import Row
from flex_ident.pooling.changes import Step, adjusted, smallest, step
from flex_ident.pooling.scatter import Scatter
from flex_ident.pooling.series import Series
from flex_ident.pooling.thresholds import FALSE_CHANGES, SESSION_S

HEALTH = "flex_ident/health/1"
COLUMNS = (
    "robot", "joint", "sha256", "sensors", "verdict", "recorded_at", "finished_at", "tag", "conditions", "parameters",
    "covariance", "method", "settings", "flex_ident_version", "bag",
)  # fmt: skip
"""What is read of the archive."""
WARMER = 5.0
"""Kelvin by which recordings must differ before a change of friction is put down to it. Set by hand."""


@dataclass(frozen=True)
class Shown:
    """A judged series with its likeliest step, the smallest change it could have shown, and whether one is named."""

    compared: Compared
    step: Step
    smallest: float
    changed: bool


def fleet_health(rows: Iterable[Row], baseline: str = "") -> dict[str, Any]:
    """The content of `flex_ident health --json` (docs/fleet.md). Raises DataError where nothing can be compared."""
    there, replaced = without_replaced(rows)
    known = histories(there, baseline)
    compared, scatter = measured([c for history in known for c in comparisons(history)])
    judged = apart_from_all(_told([(c, step(c.series, scatter[c.key])) for c in compared]))
    early = as_pairs(compared)
    newest = _told([(c, _newest(c, scatter[c.key], early)) for c in compared])
    if not judged and not newest:
        raise DataError(_cannot_tell(known))
    changes = _significant(judged)
    changed = {c.name for c, _, _ in changes}
    alone = [(c, s) for c, s in newest if c.name not in changed]
    to_confirm = _significant(alone)
    surely = {c.name for c, _ in judged}
    told = [*judged, *((c, s) for c, s in alone if c.name not in surely)]
    shown = [
        Shown(c, s, smallest(c.series, scatter[c.key], FALSE_CHANGES / len(told)), c.name in changed) for c, s in told
    ]
    by_history: dict[tuple[str, ...], list[Shown]] = {}
    for one in shown:
        by_history.setdefault(one.compared.history.name, []).append(one)
    return {
        "schema": HEALTH, "baseline": baseline or "first results",
        "false_alarms": {"method": "Benjamini-Hochberg", "rate": FALSE_CHANGES, "comparisons": len(told)},
        "smallest": _smallest(shown), "mixed": _mixed(known), "replaced": replaced,
        "joints": [
            _joint(h, by_history.get(h.name, []), _of(changes, h), _of(to_confirm, h)) for h in known
        ],
        "changes": [_change(*own) for own in changes],
        "to_confirm": [_change(*own) for own in to_confirm],
    }  # fmt: skip


_Steps = list[tuple[Compared, Step]]


def _told(steps: Iterable[tuple[Compared, Step | None]]) -> _Steps:
    return [(c, s) for c, s in steps if s is not None]


def _newest(c: Compared, scatter: Scatter, early: Mapping[tuple[str, ...], tuple[Series, Scatter]]) -> Step | None:
    """The step of the newest session alone; of three sessions also that of the last two together, as two are judged."""
    alone = step(c.series, scatter, newest=True)
    if c.name not in early:
        return alone
    both = step(*early[c.name], newest=True)
    if alone is None or both is None:
        found = both if alone is None else alone
        return None if found is None else replace(found, at=c.series.baseline) if found is both else found
    best = replace(both, at=c.series.baseline) if both.chance < alone.chance else alone
    return replace(best, chance=min(1.0, 2.0 * best.chance))


def _cannot_tell(known: Sequence[History]) -> str:
    """Why nothing of the fleet can be judged, and what would do."""
    counted = f"{len(known)} joint, and it has not" if len(known) == 1 else f"{len(known)} joints, and none has"
    return (
        f"nothing can be compared, cannot tell yet: {counted} sessions enough ({_most_sessions(known)}; recordings "
        f"within {SESSION_S / 3600.0:.0f} hours are one, as they share what a day does). Record on four days, two of "
        "them behind the baseline; with five joints or more three days do, and with twenty two."
    )


_Found = tuple[Compared, Step, float]
"""A change, and its chance adjusted over all comparisons."""


def _significant(steps: Sequence[tuple[Compared, Step]]) -> list[_Found]:
    chances = adjusted([s.chance for _, s in steps])
    return [(c, s, p) for (c, s), p in zip(steps, chances, strict=True) if p < FALSE_CHANGES]


def _change(own: Compared, found: Step, chance: float) -> dict[str, Any]:
    size = abs(found.before)
    low, high = found.interval
    percent = [100.0 * x / size if size > 0.0 else None for x in (found.after - found.before, low, high)]
    return {
        "robot": own.history.robot, "joint": own.history.joint, "model": own.history.model,
        "parameter": own.key, "unit": own.unit,
        "before": _side(found.before, own.sessions[: found.at]),
        "after": _side(found.after, own.sessions[found.at :]),
        "change": found.after - found.before, "ci95": [low, high],
        "change_percent": percent[0], "ci95_percent": percent[1:],
        "chance": chance,
        "since": {
            "after": own.told(0, found.at)[-1].at.isoformat(), "until": own.told(found.at)[0].at.isoformat(),
        },
    }  # fmt: skip


def _side(value: float, sessions: Sequence[Sequence[int]]) -> dict[str, float | int]:
    """One side of a step: the mean of its sessions."""
    return {"value": value, "results": sum(map(len, sessions)), "sessions": len(sessions)}


def _most_sessions(known: Sequence[History]) -> str:
    most = max((h.session_count for h in known), default=0)
    return f"{most} session{'' if most == 1 else 's'}{' at most' if len(known) > 1 else ''}"


def _of(changes: Sequence[_Found], history: History) -> dict[str, tuple[Compared, Step]]:
    """The changes of one joint, by parameter."""
    return {c.key: (c, s) for c, s, _ in changes if c.history is history}


def _joint(
    history: History, shown: Sequence[Shown], changes: Mapping[str, tuple[Compared, Step]],
    waiting: Mapping[str, tuple[Compared, Step]],
) -> dict[str, Any]:  # fmt: skip
    """What is said of one joint: changed, or waiting for a second result that says so, with a probable cause;
    unchanged; or not judged; and its series."""
    known = [one.compared.key for one in shown]
    own = changes or waiting
    content: dict[str, Any] = {
        "robot": history.robot, "joint": history.joint, "model": history.model, "results": len(history.results),
        "baseline_results": history.baseline, "sessions": history.session_count,
        "state": "changed" if changes else "to_confirm" if waiting else "unchanged" if known else "not_judged",
        "recorded_at": [told.at.isoformat() for told in history.results],
        "parameters": {one.compared.key: _parameter(one) for one in shown},
    }  # fmt: skip
    if own:
        sizes = {key: abs(s.before) or 1.0 for key, (_, s) in own.items()}
        relative = {key: ((s.after - s.before) / sizes[key], s.std / sizes[key]) for key, (_, s) in own.items()}
        warmer = any(_warmer(c, s) for c, s in own.values())
        other = any(_other_version(c, s) for c, s in own.values())
        content["cause"] = str(Cause.VERSION if other else probable_cause(relative, known, temperature=warmer))
    return content


def _parameter(one: Shown) -> dict[str, Any]:
    """A parameter's series, its results by their place in the joint's, and the smallest change that it could show."""
    c, size = one.compared, float(np.median(np.abs(one.compared.series.values)))
    own = [told.parameters[c.key] for told in c.told(0)]
    return {
        "unit": c.unit, "values": [value for value, _, _ in own], "stds": [std for _, std, _ in own],
        "results": list(c.places), "changed": one.changed,
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


def _other_version(own: Compared, found: Step) -> bool:
    """Whether other versions of flex_ident made the results on one side of the change than on the other."""
    first, rest = ({t.version for t in side} for side in (own.told(0, found.at), own.told(found.at)))
    return first.isdisjoint(rest)


def _mixed(known: Sequence[History]) -> list[dict[str, Any]]:
    """The joints that have several histories, by what models and methods; these are not compared with each other."""
    models: dict[tuple[str, str], list[str]] = {}
    for h in known:
        models.setdefault((h.robot, h.joint), []).append(h.model)
    return [{"robot": r, "joint": j, "models": own} for (r, j), own in models.items() if len(own) > 1]


def _warmer(own: Compared, found: Step) -> bool:
    """Whether the recordings behind the change were made at another temperature, as far as that was written down."""
    first = [t.temperature for t in own.told(0, found.at) if t.temperature is not None]
    rest = [t.temperature for t in own.told(found.at) if t.temperature is not None]
    return bool(first and rest) and abs(float(np.mean(first)) - float(np.mean(rest))) > WARMER
