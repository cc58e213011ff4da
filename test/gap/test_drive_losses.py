"""A drive that delivers less than it is asked for: named, measured, and never trusted where it is overlooked."""

from dataclasses import replace

import numpy as np
import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap.explain import explain
from flex_ident.gap.options import GapOptions
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=20.0, sample_rate_hz=500.0, profile="rich")
CHAIN = MeasurementChain.with_bits(17, 20)
LOSSES = {"torque_droop": 0.05, "iron_saturation": 2e-5}


@pytest.mark.slow
@pytest.mark.parametrize("effect", [pytest.param("torque_droop", marks=pytest.mark.campaign), "iron_saturation"])
def test_a_loss_of_torque_is_suspected_and_the_intervals_reach_as_far(effect: str) -> None:
    truth = COBOT_JOINT.with_effect(effect, {"loss": LOSSES[effect]})
    recording = virtual_recording(truth, EXPERIMENT, CHAIN, seed=4)
    result = identify(recording, IdentifyOptions())
    assert result.verdict != "trusted"
    assert any(n.code == "cause_suspected" for n in result.notices)
    for key in ("Jm", "K", "JL"):
        p = result.parameter(key)
        assert abs(p.value - truth.value(key)) < 3.0 * p.std, p


@pytest.mark.slow
@pytest.mark.campaign
def test_a_loss_by_a_law_that_is_not_ours_is_not_trusted() -> None:
    recording = virtual_recording(COBOT_JOINT, EXPERIMENT, CHAIN, seed=6)
    speed = np.gradient(recording.motor_position) * recording.sample_rate_hz
    lost = 0.05 * np.minimum(1.0, (speed / np.quantile(np.abs(speed), 0.9)) ** 2)
    result = identify(replace(recording, motor_torque=recording.motor_torque / (1.0 - lost)), IdentifyOptions())
    assert result.verdict != "trusted"
    for key in ("Jm", "K", "JL"):
        p = result.parameter(key)
        assert abs(p.value - COBOT_JOINT.value(key)) < 3.0 * p.std, p


@pytest.mark.campaign
@pytest.mark.parametrize("effect", ["torque_droop", "iron_saturation"])
def test_a_loss_of_torque_is_named_and_measured(effect: str) -> None:
    truth = COBOT_JOINT.with_effect(effect, {"loss": LOSSES[effect]})
    found = explain(virtual_recording(truth, EXPERIMENT, CHAIN, seed=5), GapOptions())
    assert [f.effect for f in found.findings] == [effect]
    loss = found.findings[0].parameters[0]
    assert loss.value == pytest.approx(LOSSES[effect], rel=0.2)


@pytest.mark.campaign
@pytest.mark.parametrize("change", [0.03, -0.03])
def test_a_gain_that_drifts_over_two_sweeps_is_in_the_intervals(change: float) -> None:
    """As a magnet warms; the effect of the catalogue is a straight line. K was 6 and 4 standard deviations off."""
    twice = Experiment(duration_s=24.0, sample_rate_hz=500.0, repeats=2, amplitude=0.2)
    recording = virtual_recording(COBOT_JOINT, twice, MeasurementChain.with_bits(17, 20, torque_noise=0.02), seed=7)
    gain = 1.0 - change * np.expm1(-recording.time / 15.0)
    result = identify(replace(recording, motor_torque=recording.motor_torque * gain), IdentifyOptions())
    for key in ("Jm", "K", "JL"):
        p = result.parameter(key)
        assert abs(p.value - COBOT_JOINT.value(key)) < 3.0 * p.std, p
        assert p.std < abs(change) * p.value, p


@pytest.mark.slow
@pytest.mark.campaign
def test_a_gain_that_drifts_far_is_named_and_measured() -> None:
    truth = COBOT_JOINT.with_effect("gain_drift", {"rate": -0.004})
    found = explain(virtual_recording(truth, EXPERIMENT, CHAIN, seed=8), GapOptions())
    assert [f.effect for f in found.findings] == ["gain_drift"]
    rate = found.findings[0].parameters[0]
    assert rate.value == pytest.approx(-0.004, rel=0.1)
    for key in ("Jm", "K", "JL"):
        p = found.final.parameter(key)
        assert abs(p.value - truth.value(key)) < 3.0 * p.std, p


@pytest.mark.slow
@pytest.mark.parametrize("settles_s", [1e6, pytest.param(8.0, marks=pytest.mark.campaign)])
def test_a_zero_that_drifts_does_not_move_gravity(settles_s: float) -> None:
    """As a strain gauge warms, read by the motor alone: gravity and a constant are all but alike over a small range."""
    recording = virtual_recording(COBOT_JOINT, EXPERIMENT, CHAIN, seed=9)
    time, whole = recording.time, recording.time[-1]
    zero = 0.6 * np.expm1(-time / settles_s) / np.expm1(-whole / settles_s)
    alone = replace(recording, motor_torque=recording.motor_torque + zero, link_position=None)
    result = identify(alone, IdentifyOptions(sensors="motor"))
    for key in ("Jm", "K", "JL", "FSm", "MX", "MY"):
        p = result.parameter(key)
        assert not p.identifiable or abs(p.value - COBOT_JOINT.value(key)) < 3.0 * p.std, p


@pytest.mark.campaign
def test_a_zero_that_drifts_far_is_named_and_measured() -> None:
    truth = COBOT_JOINT.with_effect("offset_drift", {"rate": 0.25})
    found = explain(virtual_recording(truth, EXPERIMENT, CHAIN, seed=8), GapOptions())
    assert [f.effect for f in found.findings] == ["offset_drift"]
    rate = found.findings[0].parameters[0]
    assert rate.value == pytest.approx(0.25, rel=0.1)
