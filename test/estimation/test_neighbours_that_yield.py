"""An elbow whose shoulder yields: its motor alone sees both springs, and says so; the link encoder tells its own."""

import pytest
from elbow import K, elbow_recording, seen_stiffness

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.regression.motor_equation import motor_equation


@pytest.mark.campaign
def test_from_the_motor_alone_stiffness_is_of_all_that_yields() -> None:
    shoulder = 40.0 * K
    result = identify(elbow_recording(shoulder, link=False), IdentifyOptions(sensors="motor"))
    found = result.parameter("K")
    assert "link_taken_as_rigid" in [n.code for n in result.notices]
    assert seen_stiffness(shoulder) < 0.99 * K
    assert abs(found.value - seen_stiffness(shoulder)) < max(3.0 * found.std, 0.01 * K)


@pytest.mark.parametrize("times", [1.0, 3.0, 12.0])
def test_the_motors_equation_knows_its_own_spring_whatever_yields(times: float) -> None:
    found = motor_equation(elbow_recording(times * K)).stiffness
    assert found.identifiable
    assert abs(found.value - K) < 4.0 * found.std
    assert found.std < 0.01 * K
