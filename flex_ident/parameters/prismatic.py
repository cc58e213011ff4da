"""The same numbers for a joint that slides: N, m and kg instead of N m, rad and kg m^2."""

from __future__ import annotations

from dataclasses import replace

from flex_ident.notices import Notice
from flex_ident.parameters.identification import Identification
from flex_ident.parameters.parameter import PRISMATIC_UNITS, Parameter


def prismatic(result: Identification) -> Identification:
    """The result with the units of a prismatic joint; the equations are the same."""
    return replace(
        result,
        parameters=tuple(in_metres(p) for p in result.parameters),
        measurement=tuple(in_metres(p) for p in result.measurement),
        combined=tuple(in_metres(p) for p in result.combined),
        notices=notices_in_metres(result.notices),
    )


def notices_in_metres(notices: tuple[Notice, ...]) -> tuple[Notice, ...]:
    """The notices, those about a quantity with its unit for a prismatic joint."""
    return tuple(
        n if "unit" not in n.texts
        else replace(n, texts={**n.texts, "unit": PRISMATIC_UNITS.get(n.subject, unit_in_metres(n.texts["unit"]))})
        for n in notices
    )  # fmt: skip


def in_metres(p: Parameter) -> Parameter:
    """A parameter with the unit of a prismatic joint. A phase stays an angle."""
    if p.key in PRISMATIC_UNITS:
        return replace(p, unit=PRISMATIC_UNITS[p.key])
    return p if p.key.endswith("phase") else replace(p, unit=unit_in_metres(p.unit))


def unit_in_metres(text: str) -> str:
    """A unit, or a text with units in it, for a prismatic joint."""
    return text.replace("N m", "N").replace("rad", "m").replace("kg m^2", "kg").replace("kg m²", "kg")


def slides(result: Identification) -> bool:
    """Whether a result is in the units of a prismatic joint."""
    return any(p.unit == PRISMATIC_UNITS.get(p.key) or p.unit in ("A s/m", "A/m") for p in result.parameters)
