"""Hidden effects are named, nothing is named where nothing is missing; the truth is another plant."""

import json
import math

import pytest

from flex_ident.errors import ConfigurationError, UsageError
from flex_ident.gap import GapExplanation, GapOptions, explain
from flex_ident.gap.simulator import compared_with_simulator
from flex_ident.parameters import JointModel
from flex_ident.report.gap_result import gap_content
from flex_ident.virtual_joint import COBOT_JOINT, PAPER_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=24.0, sample_rate_hz=500.0)
CHAIN = MeasurementChain(torque_noise=0.01, jitter=0.02)


def explained(model: JointModel, seed: int = 0, **options: object) -> GapExplanation:
    recording = virtual_recording(model, EXPERIMENT, CHAIN, seed=seed)
    return explain(recording, GapOptions(**options))  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize(("model", "sensors"), [(PAPER_JOINT, "motor"), (COBOT_JOINT, "motor+link")])
def test_nothing_is_named_where_nothing_is_missing(model: JointModel, sensors: str) -> None:
    found = explained(model, sensors=sensors)
    assert found.findings == ()
    assert found.verdict == "complete"
    assert found.after == pytest.approx(found.before)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "parameters", "sensors"),
    [
        # Twice the noise is left: simulated play does not strike at exactly the same moment as the joint's.
        pytest.param("backlash", {"gap": 6e-4}, "motor+link", marks=pytest.mark.campaign),
        pytest.param(
            "torque_ripple",
            {"amplitude": 2.0, "cycles_per_turn": 60.0, "phase": 0.5},
            "motor",
            marks=pytest.mark.campaign,
        ),
        pytest.param("joint_damping", {"damping": 3.0}, "motor+link", marks=pytest.mark.campaign),
        pytest.param("time_delay", {"delay": 5e-3}, "motor+link", marks=pytest.mark.campaign),
    ],
)
def test_a_hidden_effect_is_named_and_measured(effect: str, parameters: dict[str, float], sensors: str) -> None:
    found = explained(COBOT_JOINT.with_effect(effect, parameters), seed=3, sensors=sensors)
    assert found.findings, (found.verdict, found.rejected)
    first = found.findings[0]
    assert [f.effect for f in found.findings] == [effect]
    assert found.verdict == ("partly_explained" if effect == "backlash" else "explained")
    assert found.closed > (0.6 if effect == "backlash" else 0.8)
    values = {p.key: p for p in first.parameters}
    for key, true in parameters.items():
        if key != "phase":
            assert values[key].value == pytest.approx(true, rel=0.15), key
    content = gap_content(found)
    json.dumps(content, allow_nan=False)
    assert content["gap"]["steps"][0]["model"] == "base"
    assert content["findings"][0]["effect"] == effect
    assert math.isfinite(content["gap"]["noise_floor"])


@pytest.mark.slow
@pytest.mark.campaign
def test_damping_is_found_that_a_skew_of_the_encoders_stands_in_for() -> None:
    found = explained(PAPER_JOINT.with_effect("joint_damping", {"damping": 19.0}), seed=3, sensors="motor+link")
    assert [f.effect for f in found.findings] == ["joint_damping"]
    assert found.verdict == "explained"
    assert found.findings[0].parameters[0].value == pytest.approx(19.0, rel=0.1)


@pytest.mark.slow
@pytest.mark.campaign
def test_gravity_left_out_by_hand_is_found_again() -> None:
    found = explained(PAPER_JOINT, sensors="motor+link", without=("MX", "MY"))
    assert found.findings[0].effect == "gravity"
    values = {p.key: p.value for p in found.findings[0].parameters}
    assert values["MY"] == pytest.approx(-53.4, rel=0.02)


@pytest.mark.slow
def test_an_effect_put_in_by_hand_is_in_the_model() -> None:
    found = explained(COBOT_JOINT, sensors="motor+link", add=("joint_damping",), effects=("joint_damping",))
    assert found.findings[0].verdict == "by_hand"
    assert "joint_damping" in found.final.model.effects


@pytest.mark.slow
@pytest.mark.campaign
def test_repeats_tell_model_error_from_noise() -> None:
    model = COBOT_JOINT.with_effect("torque_ripple", {"amplitude": 3.0, "cycles_per_turn": 60.0, "phase": 0.0})
    experiment = Experiment(duration_s=24.0, sample_rate_hz=500.0, repeats=2)
    recording = virtual_recording(model, experiment, CHAIN, seed=1)
    found = explain(recording, GapOptions(sensors="motor+link"))
    assert found.repeats is not None
    assert found.repeats_left is not None
    assert found.repeats.period_s == pytest.approx(12.0, rel=0.01)
    assert found.repeats_left.repeatable < 0.3 * found.repeats.repeatable


@pytest.mark.slow
@pytest.mark.campaign
def test_a_simulation_that_is_off_is_told_where_and_what_it_lacks() -> None:
    truth = COBOT_JOINT.with_effect("backlash", {"gap": 6e-4})
    theirs = JointModel({**COBOT_JOINT.parameters, "FVm": 12.0, "K": 9000.0}, joint="cobot")
    options = GapOptions(sensors="motor+link", effects=("backlash", "nonlinear_stiffness", "stribeck_friction"))
    measured = explain(virtual_recording(truth, EXPERIMENT, CHAIN, seed=1), options)
    shown = [f.effect for f in measured.findings]
    simulated = virtual_recording(theirs, EXPERIMENT, CHAIN, seed=2)
    gap = compared_with_simulator(simulated, measured.final.parameters, shown, options, measured.sensors)
    off = {d.key: d for d in gap.differences if d.off}
    assert off["FVm"].percent == pytest.approx(50.0, abs=5.0)
    assert off["K"].percent == pytest.approx(-10.0, abs=2.0)
    assert "JL" not in off
    assert gap.lacks == ("backlash",)
    assert gap.has_too_much == ()


def test_options_that_make_no_sense_are_refused() -> None:
    with pytest.raises(UsageError, match="--without K"):
        GapOptions(without=("K",))
    with pytest.raises(ConfigurationError, match="unknown effect"):
        GapOptions(effects=("gremlins",))
