"""A result in the words of other tools: one file a format, each a function from a stored result to text."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from flex_ident.errors import DataError, UsageError
from flex_ident.notices import Code
from flex_ident.report.export.formats import FORMATS
from flex_ident.report.stored import StoredResult, stored_result


def exported(path: Path, to: str) -> str:
    """The result in `path` as text in one of FORMATS. Raises UsageError and DataError; a rejected result is refused."""
    if to not in FORMATS:
        raise UsageError(f"--to is '{to}': expected one of {', '.join(FORMATS)}.")
    result = stored_result(path)
    if not result.usable:
        raise DataError(_refusal(result))
    if to != "csv" and any(p.unit.startswith("A") for p in result.parameters):
        raise DataError(
            f"{result.path}: is in amperes, not in N m or N: identify with --effort-scale, N m per A, and export that."
        )
    written: Callable[[StoredResult], str] = import_module(f"{__name__}.{FORMATS[to]}").written
    return written(result)


UNSAID = (Code.NOT_IDENTIFIABLE, Code.MOTOR_EQUATION)
"""Codes that say nothing beyond the list of what is not determined."""


def _refusal(result: StoredResult) -> str:
    """Why a rejected result is not exported: the verdict and what spoke against it."""
    weak = [p.key for p in result.parameters if not p.identifiable]
    undetermined = f"not determined: {', '.join(weak)}" if weak else ""
    said = [text for code, text in result.findings if code not in UNSAID]
    why = "; ".join(text.rstrip(".") for text in (undetermined, *said[:1]) if text)
    return (
        f"{result.path}: {result.joint} was rejected{': ' + why if why else ''}. Nothing is exported: the numbers must "
        "not be used. Identify from a recording that gives a better verdict."
    )
