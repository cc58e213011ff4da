"""The same numbers where the effort is a current of unknown scale: A instead of N m or N, and what follows."""

from __future__ import annotations

import re
from dataclasses import replace

from flex_ident.notices import Code, Notice
from flex_ident.parameters.identification import Identification
from flex_ident.parameters.parameter import Parameter

INERTIAS = {"kg m^2": "A s^2/rad", "kg m²": "A s²/rad", "kg m": "A s^2/m", "kg": "A s^2/m"}
"""Units that hold the effort's without naming it, the longest first."""


def is_current(notices: tuple[Notice, ...]) -> bool:
    """Whether notices say that the effort is a current, which nothing turned into a torque."""
    return any(n.code is Code.EFFORT_CURRENT for n in notices)


def in_amperes(result: Identification) -> Identification:
    """The result with the units of a current; ratios and frequencies are what they are."""
    return replace(
        result,
        parameters=tuple(parameter_in_amperes(p) for p in result.parameters),
        notices=notices_in_amperes(result.notices),
    )


def parameter_in_amperes(p: Parameter) -> Parameter:
    """A parameter with the unit that a current gives it."""
    return replace(p, unit=unit_in_amperes(p.unit))


def notices_in_amperes(notices: tuple[Notice, ...]) -> tuple[Notice, ...]:
    """The notices, those about a quantity with its unit in amperes."""
    return tuple(
        replace(n, texts={**n.texts, "unit": unit_in_amperes(n.texts["unit"])}) if "unit" in n.texts else n
        for n in notices
    )


def unit_in_amperes(text: str) -> str:
    """A unit, or a text with units in it, for an effort in amperes."""
    for unit, other in INERTIAS.items():
        text = re.sub(rf"\b{re.escape(unit)}(?![\w^])", other, text)
    return re.sub(r"\bN\b( m\b)?", "A", text).replace("(A)", "A")
