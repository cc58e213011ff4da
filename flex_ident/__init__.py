"""Identification of flexible robot joints from one recorded chirp, and of what the model lacks.

From Python (docs/api.md): `read_recording` a bag, `identify` the joint, `explain` what the model lacks. What is named
here is loaded when it is first asked for, so that `import flex_ident` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flex_ident.bags.reading import read_recording
    from flex_ident.bags.selection import SignalSelection
    from flex_ident.errors import FlexIdentError
    from flex_ident.estimation.identification import identify
    from flex_ident.estimation.options import IdentifyOptions
    from flex_ident.gap.explain import explain
    from flex_ident.gap.explanation import Finding, GapExplanation
    from flex_ident.gap.options import GapOptions
    from flex_ident.notices import Notice
    from flex_ident.parameters import Identification, JointModel, Parameter
    from flex_ident.recording import Recording
    from flex_ident.report.sentences import sentence

__version__ = "0.1.0"
__all__ = [
    "Finding", "FlexIdentError", "GapExplanation", "GapOptions", "Identification", "IdentifyOptions", "JointModel",
    "Notice", "Parameter", "Recording", "SignalSelection", "explain", "identify", "read_recording", "sentence",
]  # fmt: skip

_HOMES = {
    "Finding": "gap.explanation", "FlexIdentError": "errors", "GapExplanation": "gap.explanation",
    "GapOptions": "gap.options", "Identification": "parameters", "IdentifyOptions": "estimation.options",
    "JointModel": "parameters", "Notice": "notices", "Parameter": "parameters", "Recording": "recording",
    "SignalSelection": "bags.selection", "explain": "gap.explain", "identify": "estimation.identification",
    "read_recording": "bags.reading", "sentence": "report.sentences",
}  # fmt: skip
"""The module of each name."""


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'flex_ident' has no attribute '{name}'")
    value = getattr(import_module(f"flex_ident.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
