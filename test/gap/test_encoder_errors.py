"""Errors of an encoder over its own angle: named and measured; the truth is the virtual joint, not ours."""

import numpy as np
import pytest

from flex_ident.estimation.estimate import fit_problem
from flex_ident.gap import GapOptions, explain
from flex_ident.likelihood.problem import values_of
from flex_ident.parameters import JointModel
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import candidates
from flex_ident.screening.linear_probe import encoder_error_change
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=20.0, sample_rate_hz=500.0, profile="rich")
WIDE = Experiment(duration_s=20.0, sample_rate_hz=500.0, profile="rich", amplitude=0.8)
CHAIN = MeasurementChain.with_bits(17, 20)
MOTOR, LINK = "motor_encoder_error", "link_encoder_error"
ON_THE_MOTOR = COBOT_JOINT.with_effect(MOTOR, {"amplitude": 1e-4, "cycles_per_turn": 100.0, "phase": 0.7})
ON_THE_LINK = COBOT_JOINT.with_effect(LINK, {"amplitude": 1e-3, "cycles_per_turn": 1.0, "phase": 0.7})


def test_a_small_error_of_the_motor_encoder_changes_what_its_linear_probe_says() -> None:
    problem = fit_problem(virtual_recording(COBOT_JOINT, EXPERIMENT, CHAIN, seed=1), sensors="motor+link")
    values = Values(COBOT_JOINT.parameters).without(("FS", "FSm"))
    small = Values({"motor_encoder_error.amplitude": 1e-6, "motor_encoder_error.cycles_per_turn": 60.0})
    whole = [b - a for a, b in zip(problem.residuals(values), problem.residuals(values | small), strict=True)]
    for simulated, linear in zip(whole, encoder_error_change(problem, values, small), strict=True):
        rows = problem.usable
        assert np.std((simulated - linear)[rows]) < 0.2 * np.std(simulated[rows])  # good enough to rank


def test_an_error_of_the_link_encoder_is_tried_where_the_joint_turns_far_enough() -> None:
    values = values_of(COBOT_JOINT)
    tried = {}
    for name, experiment in (("narrow", EXPERIMENT), ("wide", WIDE)):
        problem = fit_problem(virtual_recording(COBOT_JOINT, experiment, CHAIN, seed=1), sensors="motor+link")
        tried[name] = list(candidates(problem, values, effects=(LINK,)))
    assert tried["narrow"] == []
    assert [c.probe.columns[0]["cycles_per_turn"] for c in tried["wide"]] == [1.0, 2.0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "effect", "experiment", "link"),
    [
        pytest.param(ON_THE_MOTOR, MOTOR, EXPERIMENT, True, marks=pytest.mark.campaign),
        pytest.param(ON_THE_MOTOR, MOTOR, EXPERIMENT, False, marks=pytest.mark.campaign),
        pytest.param(ON_THE_LINK, LINK, WIDE, True, marks=pytest.mark.campaign),
    ],
)
def test_an_error_is_named_and_measured(truth: JointModel, effect: str, experiment: Experiment, link: bool) -> None:
    found = explain(virtual_recording(truth, experiment, CHAIN, seed=5, link=link), GapOptions())
    assert [f.effect for f in found.findings] == [effect], found.rejected
    sizes = {p.key: p for p in found.findings[0].parameters}
    for key in ("amplitude", "cycles_per_turn"):
        assert sizes[key].value == pytest.approx(truth.effects[effect][key], rel=0.1), key
