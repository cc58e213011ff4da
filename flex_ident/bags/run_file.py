"""What is written beside a recording of the conditions under which it was made."""

from __future__ import annotations

import math
from pathlib import Path

from flex_ident.errors import ConfigurationError
from flex_ident.parameters.documents import yaml_document
from flex_ident.recording.names import harmless, path_text, shortened

RUN_FILE = "flex_ident_run.yaml"
"""In a bag's folder: what the recording is of."""
CONDITIONS = "conditions"
MOST = 50
"""Conditions that are read."""


def run_conditions(bag: Path) -> dict[str, float | str]:
    """The `conditions` in the run file of a bag, numbers and texts by name; none where there is no such file.

    Raises ConfigurationError, naming the file, for conditions that are anything else.
    """
    file = (bag if bag.is_dir() else bag.parent) / RUN_FILE
    if not file.exists():
        return {}
    content = yaml_document(file)
    given = content.get(CONDITIONS, {}) if isinstance(content, dict) else {}
    if not isinstance(given, dict) or len(given) > MOST:
        raise ConfigurationError(f"{path_text(file)}: {CONDITIONS} is {shortened(given)}: expected names and values.")
    found: dict[str, float | str] = {}
    for name, value in given.items():
        number = isinstance(value, (int, float)) and math.isfinite(value)
        if not number and not isinstance(value, str):
            raise ConfigurationError(
                f"{path_text(file)}: condition {shortened(name)} is {shortened(value)}: expected a number or a text."
            )
        found[harmless(str(name))] = float(value) if number else harmless(str(value))
    return found
