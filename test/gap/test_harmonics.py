"""Cogging with several harmonics: each is named with its size, on the plants of `bench/plants`."""

from __future__ import annotations

import pytest
from named_cases import COBOT, HIDDEN, flexible_case

from flex_ident.gap import GapOptions, explain
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import candidates
from flex_ident.simulation.terms import HARMONICS
from flex_ident.virtual_joint import COBOT_JOINT, Experiment
from flex_ident.virtual_joint.run import virtual_recording


@pytest.fixture(scope="module")
def problem() -> FitProblem:
    return FitProblem(virtual_recording(COBOT_JOINT, Experiment(duration_s=12.0)), sensors="motor", band_hz=30.0)


@pytest.mark.parametrize("effect", ["torque_ripple", "kinematic_error"])
def test_a_periodic_effect_is_tried_again_as_its_next_harmonic(problem: FitProblem, effect: str) -> None:
    values = Values(COBOT_JOINT.parameters)
    for n in HARMONICS:
        tried = list(candidates(problem, values, effects=(effect,)))
        assert {c.keys for c in tried} == {
            (f"{effect}.amplitude{n}", f"{effect}.cycles_per_turn{n}", f"{effect}.phase{n}")
        }
        assert {c.cycles for c in tried} == {f"{effect}.cycles_per_turn{n}"}
        started = tried[0].start((0.3, 0.4))
        assert set(started) == set(tried[0].keys)
        values |= dict(zip(tried[0].keys, (0.01, 50.0, 0.1), strict=True))
    assert list(candidates(problem, values, effects=(effect,))) == []


def test_a_harmonic_that_went_is_tried_again(problem: FitProblem) -> None:
    second = {"torque_ripple.amplitude_2": 1.0, "torque_ripple.cycles_per_turn_2": 50.0, "torque_ripple.phase_2": 0.0}
    tried = candidates(problem, Values({**COBOT_JOINT.parameters, **second}), effects=("torque_ripple",))
    assert {c.suffix for c in tried} == {""}


@pytest.mark.parametrize("effect", ["backlash", "stribeck_friction"])
def test_what_is_not_periodic_is_tried_once(problem: FitProblem, effect: str) -> None:
    tried = list(candidates(problem, Values(COBOT_JOINT.parameters), effects=(effect,)))
    assert tried
    own = dict.fromkeys(tried[0].keys, 1e-4)
    assert list(candidates(problem, Values({**COBOT_JOINT.parameters, **own}), effects=(effect,))) == []


@pytest.mark.campaign
@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
def test_both_harmonics_are_named_with_their_sizes(sensors: str) -> None:
    truth = COBOT._replace(**HIDDEN["ripple_two"])
    found = explain(flexible_case("ripple_two")[0], GapOptions(sensors=sensors))
    assert [f.effect for f in found.findings] == ["torque_ripple", "torque_ripple"]
    assert found.verdict == "explained"
    told = {p.key: p for f in found.findings for p in f.parameters}
    for n, amplitude, cycles in (
        ("", truth.ripple, truth.ripple_cycles), ("_2", truth.ripple_2, truth.ripple_2_cycles)
    ):  # fmt: skip
        for key, true in ((f"amplitude{n}", amplitude), (f"cycles_per_turn{n}", cycles)):
            assert told[key].identifiable
            assert abs(told[key].value - true) < 3.0 * told[key].std, (told[key], true)
    for key in ("Jm", "K", "JL"):
        p = found.final.parameter(key)
        assert abs(p.value - getattr(truth, key)) < 3.0 * p.std, p
