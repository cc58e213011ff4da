"""An explanation for a joint that slides: N, m and kg instead of N m, rad and kg m^2."""

from __future__ import annotations

from dataclasses import replace

from flex_ident.gap.explanation import Finding, GapExplanation, Profile, Region
from flex_ident.parameters.prismatic import in_metres, notices_in_metres, prismatic, unit_in_metres


def prismatic_explanation(explanation: GapExplanation) -> GapExplanation:
    """The explanation with the units of a prismatic joint, in its texts too; the numbers are the same."""
    left = explanation.unexplained
    where, where_left = (tuple(_region(r) for r in some) for some in (explanation.where, explanation.where_left))
    return replace(
        explanation,
        unit=unit_in_metres(explanation.unit),
        final=prismatic(explanation.final),
        findings=tuple(_finding(f) for f in explanation.findings),
        where=where,
        where_left=where_left,
        notices=notices_in_metres(explanation.notices),
        unexplained=None if left is None else unit_in_metres(left),
        profiles={k: (_profile(a), _profile(b)) for k, (a, b) in explanation.profiles.items()},
    )


def _finding(found: Finding) -> Finding:
    parameters = tuple(in_metres(p) for p in found.parameters)
    return replace(found, parameters=parameters, evidence=found.evidence.replace(" N m;", " N;"))


def _region(one: Region) -> Region:
    return replace(one, text=unit_in_metres(one.text))


def _profile(one: Profile) -> Profile:
    return replace(one, unit=unit_in_metres(one.unit))
