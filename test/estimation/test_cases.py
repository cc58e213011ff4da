"""The hard cases that were once called trusted and wrong: each right, on a plant that shares nothing with the fit.

Where something is hidden: doubtful, its cause named, and intervals that hold. Where nothing is: trusted.
"""

from __future__ import annotations

from functools import cache

import pytest
from named_cases import HIDDEN, fast_loop, flexible_case, rigid_gravity

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap import GapOptions, explain
from flex_ident.notices import Code
from flex_ident.parameters import Identification

pytestmark = pytest.mark.slow
WITHIN = 3.0
"""Standard deviations within which Jm, K, JL and J lie of the truth."""
MOUNT = {"mount_mode", "second_mode"}
"""A base that gives way; one of the two is to be named."""
FRICTION = {
    "stribeck_friction", "load_dependent_friction", "viscous_nonlinearity", "viscous_asymmetry", "friction_drift",
    "hysteresis", "presliding_friction",
}  # fmt: skip
CAUSES: dict[str, set[str]] = {
    "hysteresis": {"hysteresis"},
    "backlash": {"backlash"},
    "load_friction": {"load_dependent_friction"},
    "stribeck": {"stribeck_friction"},
    "lugre": {"presliding_friction", "stribeck_friction"},  # LuGre's friction has both
    "ripple_two": {"torque_ripple"},
    "mount_25hz": MOUNT,
    "second_mode": MOUNT,
    "mujoco_friction": FRICTION,
}
SENSORS = ("motor", "motor+link")
EVERY = [pytest.param(case, sensors, marks=pytest.mark.campaign) for case in CAUSES for sensors in SENSORS]
"""Half a minute each."""


@cache
def identified(case: str, sensors: str) -> Identification:
    return identify(flexible_case(case)[0], IdentifyOptions(sensors=sensors))


def assert_holds(result: Identification, truth: dict[str, float], keys: tuple[str, ...]) -> None:
    for key in keys:
        p = result.parameter(key)
        assert p.identifiable, p
        assert abs(p.value - truth[key]) < WITHIN * p.std, (p, truth[key])


def test_every_case_is_expected() -> None:
    assert {"plain", *CAUSES} == set(HIDDEN)


@pytest.mark.parametrize("sensors", [pytest.param("motor", marks=pytest.mark.campaign), "motor+link"])
def test_plain_joint_is_trusted_with_narrow_intervals(sensors: str) -> None:
    result = identified("plain", sensors)
    truth = flexible_case("plain")[1]
    assert result.verdict == "trusted"
    assert_holds(result, truth, ("Jm", "K", "JL"))
    for key in ("Jm", "K", "JL"):
        assert result.parameter(key).relative_std_percent < 0.1, key  # nothing fixed is added to an interval
    for p in result.parameters:
        assert not p.identifiable or abs(p.value - truth.get(p.key, 0.0)) < 4.0 * p.std, p


@pytest.mark.parametrize(("case", "sensors"), EVERY)
def test_hidden_effect_makes_doubtful_and_intervals_hold(case: str, sensors: str) -> None:
    result = identified(case, sensors)
    assert result.verdict == "doubtful"
    assert_holds(result, flexible_case(case)[1], ("Jm", "K", "JL"))


@pytest.mark.parametrize(("case", "sensors"), EVERY)
def test_hidden_effect_is_named(case: str, sensors: str) -> None:
    said = {n.code: n for n in identified(case, sensors).notices}
    assert Code.CAUSE_SUSPECTED in said, sorted(said)
    assert said[Code.CAUSE_SUSPECTED].subject in CAUSES[case]


def test_rigid_joint_under_gravity_is_trusted_and_complete() -> None:
    recording, truth = rigid_gravity()
    result = identify(recording, IdentifyOptions(rigid=True))
    assert result.verdict == "trusted"
    assert_holds(result, truth, ("J",))
    for key, true in truth.items():
        p = result.parameter(key)
        assert abs(p.value - true) < 4.0 * p.std, p
    found = explain(recording, GapOptions(rigid=True))
    assert found.verdict == "complete"
    assert found.findings == ()


def test_rounding_in_a_fast_loop_is_no_torque_and_nothing_is_missing() -> None:
    recording, truth = fast_loop()
    result = identify(recording, IdentifyOptions(rigid=True))
    assert_holds(result, truth, ("J",))
    assert result.parameter("J").value == pytest.approx(truth["J"], rel=0.01)
    assert result.verdict == "trusted", [(n.code, n.subject) for n in result.notices]
    found = explain(recording, GapOptions(rigid=True))
    assert found.verdict == "complete"
    assert found.findings == ()
