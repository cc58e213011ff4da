"""A constant torque is an effect where it is certain, and the base's own where it is not sought."""

from __future__ import annotations

import pytest
from cobot_far_moved import COBOT, WIDE, played
from recordings import recording_of

from flex_ident.estimation.estimate import fit_problem
from flex_ident.gap import GapOptions, explain
from flex_ident.gap.base import fitted_base
from flex_ident.recording import Recording

OFFSET = 1.5


def recorded(sensors: str) -> Recording:
    return recording_of(played(COBOT._replace(offset=OFFSET), WIDE).recorded, sensors)


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
def test_three_percent_of_the_torque_are_named_with_their_size(sensors: str) -> None:
    explanation = explain(recorded(sensors), GapOptions(sensors=sensors))
    assert [finding.effect for finding in explanation.findings] == ["torque_offset"]
    assert explanation.verdict == "explained"
    (found,) = explanation.findings[0].parameters
    assert found.value == pytest.approx(OFFSET, abs=3.0 * found.std)
    assert found.std < 0.2


@pytest.mark.slow
@pytest.mark.campaign
def test_it_stays_in_the_base_where_other_effects_alone_are_sought() -> None:
    problem = fit_problem(recorded("motor"), sensors="motor")
    base = fitted_base(problem, GapOptions())
    assert [effect.name for effect in base.stood_for] == ["torque_offset"]
    assert "offset" not in base.kinds.fit.free
    for options in (GapOptions(effects=("backlash",)), GapOptions(staying=("torque_offset",))):
        kept = fitted_base(problem, options, base.whole)
        assert kept.stood_for == ()
        assert kept.kinds.fit.values["offset"] == pytest.approx(OFFSET, abs=0.2)
