"""Effort behind a low-pass is named where that is longer than a sample; the truth is the virtual joint, not ours."""

import pytest

from flex_ident.effects import CATALOGUE
from flex_ident.estimation.estimate import fit_problem
from flex_ident.estimation.identification import identify
from flex_ident.gap import GapOptions, explain
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording
from flex_ident.screening.anew import FitScans
from flex_ident.screening.candidates import scales_of
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=24.0, sample_rate_hz=500.0, profile="rich")
CHAIN = MeasurementChain(torque_noise=0.01, jitter=0.02)


def behind(time: float, *, link: bool = True) -> Recording:
    """A cobot's joint whose effort is low-passed with that time constant, s."""
    truth = COBOT_JOINT.with_effect("effort_lag", {"time": time})
    return virtual_recording(truth, EXPERIMENT, CHAIN, seed=8, link=link)


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("link", [True, False])
def test_a_low_pass_of_several_samples_is_named_and_measured(link: bool) -> None:
    found = explain(behind(8e-3, link=link), GapOptions())
    assert [f.effect for f in found.findings] == ["effort_lag"]
    (time,) = found.findings[0].parameters
    assert abs(time.value - 8e-3) < 3.0 * time.std < 1.5e-3
    assert all(p.key != "effort_lag" for p in found.final.measurement)
    assert found.final.parameter("K").value == pytest.approx(COBOT_JOINT.value("K"), rel=0.01)


@pytest.mark.campaign
def test_one_that_is_shorter_than_a_sample_is_measurement() -> None:
    assert explain(behind(1e-3), GapOptions()).findings == ()


@pytest.mark.slow
def test_identification_corrects_for_it_and_says_so() -> None:
    result = identify(behind(8e-3))
    assert [n.code for n in result.notices if n.subject == "motor_torque"] == ["effort_lag"]
    assert result.parameter("K").value == pytest.approx(COBOT_JOINT.value("K"), rel=0.01)


def test_a_low_pass_in_which_a_fit_is_lost_is_scanned_together_with_the_mode() -> None:
    problem = fit_problem(behind(0.03, link=False), sensors="motor")
    values = Values({**COBOT_JOINT.parameters, "K": 2e3})
    start = CATALOGUE["effort_lag"].start
    assert start is not None
    found = start(FitScans(problem, values, scales_of(problem, values)))
    assert found is not None
    assert found.effect["time"] == pytest.approx(0.03, rel=0.4)
    assert found.model["K"] == pytest.approx(COBOT_JOINT.value("K"), rel=0.15)
