"""Results read back from `result.json`."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flex_ident.errors import DataError
from flex_ident.parameters import Parameter
from flex_ident.report.result import SCHEMA


@dataclass(frozen=True)
class StoredResult:
    """The part of a `result.json` that comparisons and exports need."""

    path: Path
    joint: str
    sensors: str
    method: str
    verdict: str
    parameters: tuple[Parameter, ...]

    def value(self, key: str) -> float:
        """A parameter's value; 0 when the result does not hold it."""
        return next((p.value for p in self.parameters if p.key == key), 0.0)


def stored_result(path: Path) -> StoredResult:
    """The result in a `result.json` or in the folder that holds one. Raises DataError."""
    file = path / "result.json" if path.is_dir() else path
    if not file.exists() and (path / "gap.json").exists():
        model = path / "model.yaml"
        raise DataError(f"{path} holds an explanation, no result: identify_bag BAG --model {model} makes one.")
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise DataError(f"{file}: cannot be read ({error.strerror}).") from error
    except ValueError as error:
        raise DataError(f"{file}: is not JSON.") from error
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise DataError(f"{file}: is not a result of flex_ident: expected the schema {SCHEMA}.")
    try:
        parameters = tuple(_parameter(key, p) for key, p in content["parameters"].items())
        return StoredResult(
            file, content["joint"], content["sensors"], content["method"], content["verdict"], parameters
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DataError(f"{file}: is damaged ({error}).") from error


def _parameter(key: str, content: dict[str, Any]) -> Parameter:
    value, std = content["value"], content["std"]
    return Parameter(
        key,
        math.nan if value is None else float(value),
        math.inf if std is None else float(std),
        str(content["unit"]),
        bool(content["identifiable"]),
    )
