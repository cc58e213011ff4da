"""Dry friction that varies with the motor's angle, in the plants of `bench/plants`: named and measured."""

from __future__ import annotations

import pytest
from named_cases import COBOT
from plants.cases import Case
from plants.experiment import made
from recordings import recording_of

from flex_ident.effects import CATALOGUE
from flex_ident.gap import GapOptions, explain

UNEVEN = COBOT._replace(uneven=0.4, uneven_cycles=25.0, uneven_phase=0.7)


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
def test_friction_that_varies_with_the_angle_is_named_and_measured(sensors: str) -> None:
    case = Case(7210, 0, "cobot", "p_pi", "rich", 500.0, 2, True, "coulomb_stepping", "command")
    found = explain(recording_of(made(case, UNEVEN).recorded, sensors), GapOptions(sensors=sensors))
    assert [f.effect for f in found.findings] == ["position_dependent_friction"]
    told = {p.key: p for p in found.findings[0].parameters}
    truth = {"amplitude": 0.4 * COBOT.FSm, "cycles_per_turn": 25.0, "phase": 0.7}
    for key, value in truth.items():
        assert abs(told[key].value - value) < 3.0 * told[key].std, told[key]
    for key in ("Jm", "K", "JL"):
        p = found.final.parameter(key)
        assert abs(p.value - getattr(COBOT, key)) < 3.0 * p.std, p


def test_friction_does_not_vary_by_more_than_there_is() -> None:
    effect = CATALOGUE["position_dependent_friction"]
    assert effect.reach is not None
    assert effect.reach({"amplitude": 3.0}, {"FSm": 4.0}) is None
    assert effect.reach({"amplitude": 1.0, "amplitude_2": 6.0}, {"FSm": 4.0}) is not None
