"""Errors of the motor's encoder over its own angle: named and measured; the truth is the virtual joint, not ours."""

import numpy as np
import pytest

from flex_ident.estimation.estimate import fit_problem
from flex_ident.gap import GapOptions, explain
from flex_ident.parameters.values import Values
from flex_ident.screening.linear_probe import encoder_error_change
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain, virtual_recording

EXPERIMENT = Experiment(duration_s=20.0, sample_rate_hz=500.0, profile="rich")
CHAIN = MeasurementChain.with_bits(17, 20)
ERROR = {"amplitude": 1e-4, "cycles_per_turn": 100.0, "phase": 0.7}


def test_a_small_error_changes_what_its_linear_probe_says() -> None:
    problem = fit_problem(virtual_recording(COBOT_JOINT, EXPERIMENT, CHAIN, seed=1), sensors="motor+link")
    values = Values(COBOT_JOINT.parameters).without(("FS", "FSm"))
    small = Values({"motor_encoder_error.amplitude": 1e-6, "motor_encoder_error.cycles_per_turn": 60.0})
    whole = [b - a for a, b in zip(problem.residuals(values), problem.residuals(values | small), strict=True)]
    for simulated, linear in zip(whole, encoder_error_change(problem, values, small), strict=True):
        rows = problem.usable
        assert np.std((simulated - linear)[rows]) < 0.2 * np.std(simulated[rows])  # good enough to rank


@pytest.mark.slow
@pytest.mark.parametrize("link", [True, pytest.param(False, marks=pytest.mark.campaign)])
def test_an_error_is_named_and_measured(link: bool) -> None:
    truth = COBOT_JOINT.with_effect("motor_encoder_error", ERROR)
    found = explain(virtual_recording(truth, EXPERIMENT, CHAIN, seed=5, link=link), GapOptions())
    assert [f.effect for f in found.findings] == ["motor_encoder_error"], found.rejected
    sizes = {p.key: p for p in found.findings[0].parameters}
    for key in ("amplitude", "cycles_per_turn"):
        assert sizes[key].value == pytest.approx(ERROR[key], rel=0.1), key
