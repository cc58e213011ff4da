"""A cable or balancing spring: named where the range of motion shows it, and in the intervals where it does not."""

from __future__ import annotations

import math

import pytest
from cobot_far_moved import COBOT, NARROW, WIDE, played
from plants.laws import GRAVITY, Joint
from recordings import recording_of

from flex_ident.effects import CATALOGUE
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap import GapOptions, explain
from flex_ident.parameters import Identification
from flex_ident.parameters.values import Values

WEIGHT = GRAVITY * math.hypot(COBOT.MX, COBOT.MY)
SPRING = COBOT._replace(cable=0.3 * WEIGHT, cable_rest=0.2)
BALANCED = COBOT._replace(cable=-0.3 * WEIGHT, cable_rest=-0.4)
LEVER = COBOT._replace(double=0.15 * WEIGHT, double_phase=0.5)


def identified(joint: Joint, travel: float, sensors: str) -> Identification:
    return identify(recording_of(played(joint, travel).recorded, sensors), IdentifyOptions(sensors=sensors))


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("joint", [SPRING, BALANCED, LEVER], ids=["spring", "balanced", "lever"])
def test_what_pulls_beside_gravity_is_suspected_over_a_large_range(joint: Joint) -> None:
    result = identified(joint, WIDE, "motor+link")
    for key in ("Jm", "K", "JL"):
        p = result.parameter(key)
        assert not p.identifiable or abs(p.value - getattr(joint, key)) < 3.0 * p.std, p
    assert result.verdict != "trusted"
    assert ("cause_suspected", "cable_torque") in [(n.code, n.subject) for n in result.notices]


@pytest.mark.slow
@pytest.mark.campaign
def test_over_a_small_range_it_is_said_and_leaves_the_rest_of_the_joint_right() -> None:
    pulled = identified(SPRING, NARROW, "motor+link")
    for key in ("Jm", "K", "JL"):
        assert abs(pulled.parameter(key).value - getattr(SPRING, key)) < 3.0 * pulled.parameter(key).std
    assert "gravity_taken_alone" in [n.code for n in identified(COBOT, NARROW, "motor+link").notices]
    assert "gravity_taken_alone" not in [n.code for n in identified(COBOT, WIDE, "motor+link").notices]


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
def test_a_cable_is_named_and_measured_where_the_range_shows_it(sensors: str) -> None:
    found = explain(recording_of(played(SPRING, WIDE).recorded, sensors), GapOptions(sensors=sensors))
    assert [f.effect for f in found.findings] == ["cable_torque"]
    told = {p.key: p for p in found.findings[0].parameters}["stiffness"]
    assert told.value == pytest.approx(SPRING.cable, rel=0.2)
    assert abs(told.value - SPRING.cable) < 3.0 * told.std


def test_what_may_be_unseen_follows_the_weight_and_a_spring_that_is_known_leaves_the_constant() -> None:
    unseen = CATALOGUE["cable_torque"].unseen
    assert unseen is not None
    assert unseen(Values({"K": 1e4, "MX": 0.0})) == ()
    assert [set(one.columns[0]) for one in unseen(Values({"MX": 0.0, "MY": -3.0}))] == [
        {"stiffness"},
        {"cosine"},
        {"sine"},
    ]
    known = Values({"MY": -3.0, "cable_torque.stiffness": 5.0})
    assert unseen(known | {"cable_torque.torque": 1.0, "offset": 2.0}) == ()
    assert [one.columns for one in unseen(known | {"offset": -2.0})] == [({"torque": 2.0},)]
