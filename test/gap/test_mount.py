"""A base that gives way is named, measured and told from a second mode of the link, on the plants of `bench/plants`."""

from __future__ import annotations

import math

import numpy as np
import pytest
from named_cases import COBOT, HIDDEN, MOUNT, flexible_case

from flex_ident.effects import CATALOGUE
from flex_ident.estimation.estimate import fit_problem
from flex_ident.gap import GapOptions, explain
from flex_ident.likelihood.problem import values_of
from flex_ident.parameters.values import Values
from flex_ident.screening.linear_probe import mount_change
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

CLEAN = MeasurementChain(1e-9, 1e-9, 0.0, 0.0)


def base(inertia: float, hertz: float, ratio: float) -> dict[str, float]:
    omega = 2.0 * math.pi * hertz
    return {"inertia": inertia, "stiffness": inertia * omega**2, "damping": 2.0 * ratio * inertia * omega}


def test_a_heavy_base_is_none() -> None:
    recording = virtual_recording(COBOT_JOINT, Experiment(duration_s=12.0), CLEAN)
    problem = fit_problem(recording, sensors="motor+link")
    values = values_of(COBOT_JOINT)
    heavy = values | Values.of_effect("mount_mode", base(1e9, 15.0, 0.03))
    for one, other in zip(problem.residuals(values), problem.residuals(heavy), strict=True):
        assert np.std((one - other)[problem.usable]) < 1e-6 * np.std(problem.torque)


def test_what_a_base_changes_is_ranked_without_a_simulation() -> None:
    recording = virtual_recording(COBOT_JOINT, Experiment(duration_s=16.0), CLEAN)
    problem = fit_problem(recording, sensors="motor+link")
    values = values_of(COBOT_JOINT)
    mount = Values.of_effect("mount_mode", base(200.0, 18.0, 0.05))
    quick = mount_change(problem, values, problem.terms(mount))
    before, after = problem.residuals(values), problem.residuals(values | mount)
    for estimate, r0, r1 in zip(quick, before, after, strict=True):
        change = (r1 - r0)[problem.usable]
        alike = estimate[problem.usable] @ change / np.linalg.norm(estimate[problem.usable]) / np.linalg.norm(change)
        assert alike > 0.9


def test_the_two_are_said_to_be_confused_with_the_experiment_that_tells() -> None:
    assert "second_mode" in CATALOGUE["mount_mode"].confused_with
    assert "mount_mode" in CATALOGUE["second_mode"].mistaken_for
    assert "base" in CATALOGUE["mount_mode"].separated_by
    assert "base" in CATALOGUE["second_mode"].separated_by


@pytest.mark.campaign
@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
def test_a_base_is_named_and_measured(sensors: str) -> None:
    truth = COBOT._replace(**HIDDEN["mount_25hz"])
    found = explain(flexible_case("mount_25hz")[0], GapOptions(sensors=sensors))
    assert [f.effect for f in found.findings] == ["mount_mode"]
    told = {p.key: p for p in found.findings[0].parameters}
    assert told["inertia"].value == pytest.approx(MOUNT, rel=0.03)
    hertz = math.sqrt(told["stiffness"].value / told["inertia"].value) / (2.0 * math.pi)
    assert hertz == pytest.approx(25.0, rel=0.01)
    for key in ("Jm", "K", "JL"):
        p = found.final.parameter(key)
        assert abs(p.value - getattr(truth, key)) < 3.0 * p.std, p


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
def test_a_second_mode_of_the_link_is_not_taken_for_the_base(sensors: str) -> None:
    truth = COBOT._replace(**HIDDEN["second_mode"])
    found = explain(flexible_case("second_mode")[0], GapOptions(sensors=sensors))
    assert [f.effect for f in found.findings] == ["second_mode"]
    told = {p.key: p.value for p in found.findings[0].parameters}
    assert told["inertia"] == pytest.approx(truth.second_inertia, rel=0.03)
    assert told["stiffness"] == pytest.approx(truth.second_stiffness, rel=0.03)
