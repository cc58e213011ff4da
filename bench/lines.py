"""Files of a line a result."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

Line = dict[str, Any]


def lines_in(path: Path) -> list[Line]:
    """The lines of a file; a last line that was cut off is left out."""
    lines: list[Line] = []
    for text in path.read_text().splitlines() if path.exists() else []:
        try:
            lines.append(json.loads(text))
        except json.JSONDecodeError:
            continue
    return lines


def parameter_columns(result: Any) -> Line:
    """The parameters of an `Identification` as a line holds them, by key."""
    return {
        p.key: {
            "value": float(p.value), "std": float(p.std), "interval": [float(v) for v in p.interval],
            "identifiable": bool(p.identifiable),
        }
        for p in result.parameters
    }  # fmt: skip
