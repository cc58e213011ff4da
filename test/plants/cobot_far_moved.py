"""A cobot's joint of `bench/plants` moved over a range of one's choice: what depends on the angle shows over a
large one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from named_cases import COBOT
from plants.cases import Case
from plants.experiment import Made, made
from plants.joints import SIZES
from plants.laws import Joint

__all__ = ["COBOT", "NARROW", "WIDE", "played"]

NARROW, WIDE = 0.1, 0.5
"""Travel to each side, rad."""


@cache
def played(joint: Joint, travel: float, seed: int = 7110) -> Made:
    """The joint moved over `travel` rad to each side, twice that while it is slow."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(SIZES, "cobot", replace(SIZES["cobot"], travel=travel))
        return made(Case(seed, 0, "cobot", "p_pi", "rich", 500.0, 2, True, "coulomb_stepping", "command"), joint)
