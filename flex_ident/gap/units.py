"""An explanation in other units, its numbers the same: for a joint that slides, or for an effort in amperes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from flex_ident.gap.explanation import Finding, GapExplanation, Profile, Region
from flex_ident.notices import Notice
from flex_ident.parameters import Identification, Parameter
from flex_ident.parameters.current import in_amperes, notices_in_amperes, parameter_in_amperes, unit_in_amperes
from flex_ident.parameters.prismatic import in_metres, notices_in_metres, prismatic, unit_in_metres

Words = Callable[[str], str]


def prismatic_explanation(explanation: GapExplanation) -> GapExplanation:
    """The explanation with the units of a prismatic joint: N, m and kg."""
    e = _converted(explanation, prismatic(explanation.final), notices_in_metres(explanation.notices), unit_in_metres)
    return replace(e, findings=tuple(_finding(f, in_metres, unit_in_metres) for f in e.findings))


def explanation_in_amperes(explanation: GapExplanation) -> GapExplanation:
    """The explanation of an effort that is a current of unknown scale: A instead of N m or N."""
    final, notices = in_amperes(explanation.final), notices_in_amperes(explanation.notices)
    e = _converted(explanation, final, notices, unit_in_amperes)
    return replace(e, findings=tuple(_finding(f, parameter_in_amperes, unit_in_amperes) for f in e.findings))


def _converted(
    explanation: GapExplanation, final: Identification, notices: tuple[Notice, ...], words: Words
) -> GapExplanation:
    return replace(
        explanation,
        unit=words(explanation.unit),
        final=final,
        where=tuple(_region(r, words) for r in explanation.where),
        where_left=tuple(_region(r, words) for r in explanation.where_left),
        notices=notices,
        profiles={k: (_profile(a, words), _profile(b, words)) for k, (a, b) in explanation.profiles.items()},
    )


def _finding(found: Finding, converted: Callable[[Parameter], Parameter], words: Words) -> Finding:
    curve = None if found.curve is None else replace(found.curve, unit=words(found.curve.unit))
    return replace(found, parameters=tuple(converted(p) for p in found.parameters), curve=curve)


def _region(one: Region, words: Words) -> Region:
    return replace(one, unit=words(one.unit))


def _profile(one: Profile, words: Words) -> Profile:
    return replace(one, unit=words(one.unit))
