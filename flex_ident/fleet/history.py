"""From the archive's rows to each joint's history: results in the order of their recordings, and its baseline."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from typing import Any

from flex_ident.errors import DataError
from flex_ident.fleet.ratios import ratios
from flex_ident.fleet.rows import Row
from flex_ident.pooling.sessions import sessions_of
from flex_ident.pooling.thresholds import FIRST_SESSIONS
from flex_ident.recording.names import harmless

USABLE = ("trusted", "doubtful")


@dataclass(frozen=True)
class Told:
    """One result: when it was recorded, and value, standard deviation and unit of each parameter it determines."""

    at: datetime
    tag: str
    parameters: dict[str, tuple[float, float, str]]
    temperature: float | None


@dataclass(frozen=True)
class History:
    """The results of one joint by one model, in the order of their recordings; the first `baseline` are what it was.

    `sessions` number those that were recorded together, from 0.
    """

    robot: str
    joint: str
    model: str
    results: tuple[Told, ...]
    baseline: int
    sessions: tuple[int, ...]

    @property
    def session_count(self) -> int:
        """How many sessions there are."""
        return len(set(self.sessions))

    @property
    def name(self) -> tuple[str, str, str]:
        """Robot, joint and model."""
        return self.robot, self.joint, self.model


def histories(rows: Iterable[Row], baseline: str = "") -> list[History]:
    """Each joint's history; of a recording that was identified several times the last result counts.

    `baseline`: a date (results of recordings up to the end of it), a tag, or empty (the first results). Results
    before the first tagged one are left out. Raises DataError where no result has the tag or is as old.
    """
    found: dict[tuple[str, str, str], dict[str, tuple[datetime, Told]]] = {}
    for row in rows:
        if row["verdict"] in USABLE:
            told = _told(row)
            key = row["robot"], row["joint"], f"{'rigid' if 'J' in told.parameters else 'flexible'}, {row['sensors']}"
            own = found.setdefault(key, {})
            if row["sha256"] not in own or own[row["sha256"]][0] <= row["finished_at"]:
                own[row["sha256"]] = row["finished_at"], told
    made = [_history(key, [told for _, told in own.values()], baseline) for key, own in sorted(found.items())]
    if baseline and not any(h.baseline for h in made):
        tags = sorted({told.tag for own in found.values() for _, told in own.values() if told.tag})
        known = f"tags: {', '.join(tags)}" if tags else "no result has a tag"
        raise DataError(f"--baseline {harmless(baseline)}: no result is of that tag or date ({known}).")
    return made


def _history(key: tuple[str, str, str], results: Sequence[Told], baseline: str) -> History:
    """A joint's history. The baseline is of whole sessions, but where a tag parts one."""
    ordered = sorted(results, key=lambda told: told.at)
    until = _date(baseline)
    if baseline and until is None:
        tagged = [told for told in ordered if told.tag == baseline]
        later = [told for told in ordered if told.tag != baseline and tagged and told.at > tagged[0].at]
        first, rest = _sessions(tagged), _sessions(later)
        sessions = (*first, *(own + len(set(first)) for own in rest))
        return History(*key, (*tagged, *later), len(tagged), sessions)
    sessions = _sessions(ordered)
    if until is not None:
        early = {s for s, told in zip(sessions, ordered, strict=True) if told.at.date() <= until}
        count = sum(s in early for s in sessions)
    else:
        first_sessions = min(FIRST_SESSIONS, max(1, len(set(sessions)) - 2))
        count = sum(s < first_sessions for s in sessions)
    return History(*key, tuple(ordered), count, sessions)


def _sessions(ordered: Sequence[Told]) -> tuple[int, ...]:
    return sessions_of([told.at.timestamp() for told in ordered])


def _date(text: str) -> date | None:
    try:
        return date.fromisoformat(text)
    except ValueError:
        return None


def _told(row: Row) -> Told:
    content: dict[str, Any] = json.loads(row["parameters"])
    known = {
        key: (float(p["value"]), float(p["std"]), str(p["unit"]))
        for key, p in content.items()
        if p["identifiable"] and p["value"] is not None and p["std"] is not None and p["std"] > 0.0
    }
    known |= ratios(known, row.get("covariance"))
    temperature = json.loads(row["conditions"] or "{}").get("temperature")
    number = isinstance(temperature, (int, float)) and math.isfinite(temperature)
    at = row["recorded_at"] or row["finished_at"]
    return Told(at.astimezone(UTC), row["tag"] or "", known, float(temperature) if number else None)
