"""Results read back from `result.json` and `gap.json`."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flex_ident.errors import ConfigurationError, DataError
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Covariance, Parameter
from flex_ident.parameters.documents import json_document
from flex_ident.recording.names import harmless, path_text, shortened
from flex_ident.report import schemas
from flex_ident.report.sentences import finding_of

FILES = ("result.json", "gap.json")
"""What a folder may hold, the one that counts first."""
LONGEST_TEXT = 4096
"""Characters of a text in them, at most."""
MOST_KEYS = 500
"""Parameters of a covariance, at most."""


@dataclass(frozen=True)
class StoredResult:
    """The part of a `result.json`, or of a `gap.json` and its final model, that comparisons and exports need."""

    path: Path
    joint: str
    sensors: str
    method: str
    verdict: str
    parameters: tuple[Parameter, ...]
    findings: tuple[tuple[str, str], ...] = ()
    """Code and sentence of each warning, without what to do."""
    covariance: Covariance | None = None
    recordings: frozenset[str] = frozenset()
    """The hashes of the recordings that it is of; none where the file does not say."""

    @property
    def usable(self) -> bool:
        """Whether the numbers may be used at all."""
        return self.verdict != "rejected" and all(code != Code.BASE_NOT_DETERMINED for code, _ in self.findings)

    @property
    def rigid(self) -> bool:
        """Whether the model has no spring."""
        return any(p.key == "J" for p in self.parameters)

    @property
    def slides(self) -> bool:
        """Whether the joint is prismatic: its inertia is a mass."""
        return self.unit("J" if self.rigid else "Jm") == "kg"

    def value(self, key: str) -> float:
        """A parameter's value; 0 when the result does not hold it."""
        return next((p.value for p in self.parameters if p.key == key), 0.0)

    def unit(self, key: str) -> str:
        """A parameter's unit; empty when the result does not hold it."""
        return next((p.unit for p in self.parameters if p.key == key), "")

    def determines(self, key: str) -> bool:
        """Whether the recording determines the parameter, or the result does not hold it."""
        return all(p.identifiable for p in self.parameters if p.key == key)

    def number(self, key: str, *, lowest: float = -math.inf) -> float:
        """A parameter's value, at least `lowest`; 0 when the result does not hold it as a number."""
        value = self.value(key)
        return max(lowest, value) if math.isfinite(value) else 0.0

    def positive(self, key: str) -> float:
        """An inertia or a stiffness. Raises DataError when it is none."""
        value = self.value(key)
        if not (math.isfinite(value) and value > 0.0):
            raise DataError(f"{path_text(self.path)}: {key} is {value:.4g}: it must be positive to be exported.")
        return value


def stored_result(path: Path) -> StoredResult:
    """The result in a `result.json` or `gap.json`, or in the folder that holds one. Raises DataError."""
    file = path
    if path.is_dir():
        file = next((path / name for name in FILES if os.path.lexists(path / name)), path / FILES[0])
    try:
        content = json_document(file)
    except ConfigurationError as error:
        raise DataError(str(error)) from error
    return result_in(content, file)


def result_in(content: Any, file: Path) -> StoredResult:
    """The result in the content of a `result.json` or `gap.json`, read from `file`. Raises DataError."""
    shown = path_text(file)
    schema = content.get("schema") if isinstance(content, dict) else None
    if schema not in (schemas.RESULT, schemas.GAP):
        raise DataError(
            f"{shown}: is not a result of flex_ident: expected the schema {schemas.RESULT} or {schemas.GAP}."
        )
    try:
        return StoredResult(
            file,
            _text(content["joint"]),
            _text(content["sensors"]),
            _text(content["method"]) if schema == schemas.RESULT else "explain_gap",
            _text(content["verdict"]),
            tuple(_parameter(key, p) for key, p in content["parameters"].items()),
            tuple(_finding(w) for w in content.get("warnings", [])),
            _covariance(content.get("covariance")),
            _hashes(content),
        )
    except KeyError as error:
        raise DataError(f"{shown}: is damaged ({shortened(error.args[0])} is missing).") from error
    except (TypeError, ValueError, AttributeError) as error:
        raise DataError(f"{shown}: is damaged ({harmless(str(error))[:80]}).") from error


def _text(value: object) -> str:
    """A short text of a file, harmless. Raises ValueError for what is none."""
    if not isinstance(value, str) or len(value) > LONGEST_TEXT:
        raise ValueError(f"expected a text, not {shortened(value)}")
    return harmless(value)


def _number(value: object) -> float:
    """A number of a file. Raises ValueError for what is none."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"expected a number, not {shortened(value)}")
    return float(value)


def _parameter(key: str, content: dict[str, Any]) -> Parameter:
    value, std = content["value"], content["std"]
    return Parameter(
        _text(key),
        math.nan if value is None else _number(value),
        math.inf if std is None else _number(std),
        _text(content["unit"]),
        bool(content["identifiable"]),
    )


def _covariance(content: Any) -> Covariance | None:
    """The covariance of a file, if it has one. Raises ValueError for what is none."""
    if content is None:
        return None
    keys = tuple(_text(key) for key in content["keys"])
    if len(keys) > MOST_KEYS:
        raise ValueError(f"covariance of {len(keys)} parameters")
    matrix = [[_number(value) for value in row] for row in content["matrix"]]
    if any(len(row) != len(keys) for row in matrix) or len(matrix) != len(keys):
        raise ValueError("covariance and its keys differ in length")
    return Covariance(keys, np.array(matrix).reshape(len(keys), len(keys)), np.zeros(len(keys)))


def _hashes(content: dict[str, Any]) -> frozenset[str]:
    """The hashes of the recordings: of each of several, or of the one."""
    owners = content.get("recordings") or [content.get("bag")]
    found = [_text(own["sha256"]) for own in owners if isinstance(own, dict) and "sha256" in own]
    return frozenset(text for text in found if text)


def _finding(warning: dict[str, Any]) -> tuple[str, str]:
    """A warning's code, and its sentence without what to do where its numbers are there to make it."""
    code, left = _text(warning["code"]), (warning.get("numbers") or {}).get("left_percent")
    if code == Code.MODEL_MISMATCH and left is not None:
        return code, finding_of(Notice(Code.MODEL_MISMATCH, numbers={"left_percent": _number(left)}))
    return code, _text(warning["message"])
