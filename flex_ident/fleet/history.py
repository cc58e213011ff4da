"""From the archive's rows to each joint's history: results in the order of their recordings, and its baseline."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from typing import Any

from flex_ident.configuration.settings import IDENTIFY_SETTINGS, IMPORT_SETTINGS
from flex_ident.errors import DataError, UsageError
from flex_ident.fleet.ratios import ratios
from flex_ident.fleet.rows import Row
from flex_ident.pooling.sessions import sessions_of
from flex_ident.pooling.thresholds import FIRST_SESSIONS
from flex_ident.recording.names import harmless

_DATE_LIKE = re.compile(r"\d{4}-\d{1,2}-\d{1,2}")
USABLE = ("trusted", "doubtful")
DEFAULTS = {setting.key: setting.default for setting in (*IDENTIFY_SETTINGS, *IMPORT_SETTINGS)}
NO_MATTER = ("joint", "out", "type_file", "type_file_sha256", "cutoff_sweep", "model")
"""Settings that say which joint, where things are, or what else to draw; of a model file the hash is what counts."""


@dataclass(frozen=True)
class Told:
    """One result: when it was recorded, and value, standard deviation and unit of each parameter it determines."""

    at: datetime
    tag: str
    parameters: dict[str, tuple[float, float, str]]
    temperature: float | None
    version: str


@dataclass(frozen=True)
class History:
    """The results of one joint by one model and method, in the order of their recordings; the first `baseline` are what
    it was.

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
    """Each joint's histories; of a recording that was identified several times in the same way the last result counts.

    Another method, or other settings, give other numbers of the same joint: such results have a history of their own.

    `baseline`: a date (results of recordings up to the end of it), a tag, or empty (the first results). Results
    before the first tagged one are left out. Raises DataError where no result has the tag or is as old, and UsageError
    for what is no day.
    """
    last: dict[tuple[str, str, str, str], tuple[Row, Told]] = {}
    for row in rows:
        if row["verdict"] in USABLE:
            told = _told(row)
            model = f"{'rigid' if 'J' in told.parameters else 'flexible'}, {row['sensors']}, {_method(row)}"
            recording = row["robot"], row["joint"], model, row["sha256"]
            if recording not in last or last[recording][0]["finished_at"] <= row["finished_at"]:
                last[recording] = row, told
    found: dict[tuple[str, str, str], list[Told]] = {}
    for (robot, joint, model, _), (_, told) in last.items():
        found.setdefault((robot, joint, model), []).append(told)
    tags = sorted({told.tag for own in found.values() for told in own if told.tag})
    if _DATE_LIKE.fullmatch(baseline) and _date(baseline) is None and baseline not in tags:
        raise UsageError(f"--baseline {harmless(baseline)}: there is no such day, and no such tag: give YYYY-MM-DD.")
    made = [_history(key, own, baseline) for key, own in sorted(found.items())]
    if baseline and not any(h.baseline for h in made):
        known = f"tags: {', '.join(tags)}" if tags else "no result has a tag"
        raise DataError(f"--baseline {harmless(baseline)}: no result is of that tag or date ({known}).")
    return made


def _method(row: Row) -> str:
    """The method of a result, and the settings that are not as they are by default, as far as they change numbers."""
    given = json.loads(row["settings"] or "{}")
    other = [
        f"{key} {value}" for key, value in sorted(given.items())
        if key not in NO_MATTER and value != DEFAULTS.get(key, "")
    ]  # fmt: skip
    return ", ".join([row["method"], *map(harmless, other)])


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
    return Told(at.astimezone(UTC), row["tag"] or "", known, float(temperature) if number else None,
                row["flex_ident_version"] or "")  # fmt: skip
