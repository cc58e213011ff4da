"""The archive's columns, and a row from a result or from what went wrong."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from flex_ident import __version__
from flex_ident.parameters import FLEXIBLE_KEYS, RIGID_KEYS
from flex_ident.pooling.sessions import FIRST_DATE_S

ARCHIVE = "flex_ident/archive/1"
ERROR = "error"
"""The verdict where there is no result."""
Row = dict[str, Any]
KEYS = tuple(dict.fromkeys((*FLEXIBLE_KEYS, *RIGID_KEYS)))
"""Parameters that have columns of their own; all are in `parameters`."""

TEXTS = (
    "archive", "robot", "joint", "bag", "sha256", "recorded_at", "tag", "conditions", "flex_ident_version", "settings",
    "sensors", "method", "verdict", "message", "again", "warnings",
)  # fmt: skip
ENDS = ("parameters", "covariance", "finished_at", "seconds", "result")
COLUMNS = (*TEXTS, *(name for key in KEYS for name in (key, f"{key}_std")), *ENDS)
TIMES, FLAGS = ("recorded_at", "finished_at"), ("again",)
NUMBERS = ("seconds", *(name for key in KEYS for name in (key, f"{key}_std")))
"""What is no text: times in UTC, yes or no, and numbers."""


def common_row(
    *, robot: str, bag: str, sha256: str, tag: str, conditions: Mapping[str, float | str], settings: Mapping[str, Any]
) -> Row:
    """What all rows of one recording share; every column is there, empty where nothing is known."""
    return {
        **dict.fromkeys(COLUMNS), "archive": ARCHIVE, "robot": robot, "bag": bag, "sha256": sha256, "tag": tag,
        "conditions": _json(conditions), "flex_ident_version": __version__, "settings": _json(settings),
        "again": False, "warnings": "", "message": "",
    }  # fmt: skip


def result_row(common: Row, content: Mapping[str, Any], *, start_time_s: float, seconds: float) -> Row:
    """The row of a result: `content` as in `result.json`; `start_time_s` since 1970, 0 where it is not known."""
    row = {
        **common, "joint": content["joint"], "sensors": content["sensors"], "method": content["method"],
        "verdict": content["verdict"], "warnings": ",".join(w["code"] for w in content["warnings"]),
        "recorded_at": datetime.fromtimestamp(start_time_s, UTC) if start_time_s > FIRST_DATE_S else None,
        "parameters": _json(content["parameters"]), "covariance": _json(content.get("covariance")),
        "finished_at": datetime.now(UTC), "seconds": seconds, "result": _json(content),
    }  # fmt: skip
    for key, parameter in content["parameters"].items():
        if key in KEYS and parameter["identifiable"]:
            row[key], row[f"{key}_std"] = parameter["value"], parameter["std"]
    return row


def error_row(common: Row, joint: str, message: str, *, seconds: float = math.nan, again: bool = False) -> Row:
    """The row of a recording, or a joint of it, that has no result. `again`: the next run tries it again."""
    return {
        **common, "joint": joint, "verdict": ERROR, "message": message, "again": again,
        "finished_at": datetime.now(UTC), "seconds": None if math.isnan(seconds) else seconds,
    }  # fmt: skip


def _json(value: object) -> str | None:
    return None if value is None else json.dumps(value, allow_nan=False)
