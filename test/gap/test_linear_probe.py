"""The cheap estimates of what a small effect changes, against the simulations that they stand in for."""

import numpy as np
import pytest

from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.values import Values
from flex_ident.screening.linear_probe import second_mode_change, transmission_error_change
from flex_ident.virtual_joint import PAPER_JOINT, PERFECT, Experiment
from flex_ident.virtual_joint.run import virtual_recording


@pytest.mark.parametrize("late", [{}, {"time_delay.delay": 8e-3, "link_skew": 3e-3}])
def test_a_small_transmission_error_is_seen_as_late_as_the_signals_are(late: dict[str, float]) -> None:
    recording = virtual_recording(PAPER_JOINT, Experiment(duration_s=20.0, sample_rate_hz=500.0), PERFECT)
    problem = FitProblem(recording, sensors="motor+link", band_hz=30.0)
    values = Values({**PAPER_JOINT.parameters, **late})
    wave = {"amplitude": 1e-5, "cycles_per_turn": 223.5, "phase": 0.7}
    probe = Values.of_effect("kinematic_error", wave)
    before, after = problem.residuals(values), problem.residuals(values | probe)
    for estimate, r0, r1, allowed in zip(
        transmission_error_change(problem, values, probe), before, after, (0.1, 0.4), strict=True
    ):  # the link's dry friction is left out: good enough to rank
        change = (r1 - r0)[problem.usable]
        assert np.linalg.norm(estimate[problem.usable] - change) < allowed * np.linalg.norm(change)


@pytest.mark.parametrize("frequency_hz", [6.0, 12.0, 20.0])
def test_a_small_second_mass_is_seen_where_and_as_large_as_it_is(frequency_hz: float) -> None:
    recording = virtual_recording(PAPER_JOINT, Experiment(duration_s=20.0, sample_rate_hz=500.0), PERFECT)
    problem = FitProblem(recording, sensors="motor+link", band_hz=30.0)
    values = Values(PAPER_JOINT.parameters)
    omega, inertia = 2.0 * np.pi * frequency_hz, 0.01 * values["JL"]
    second = {"inertia": inertia, "stiffness": inertia * omega**2, "damping": 0.06 * inertia * omega}
    probe = Values.of_effect("second_mode", second)
    before = problem.residuals(values)
    after = problem.residuals(values | {"JL": values["JL"] - inertia} | probe)
    for estimate, r0, r1 in zip(second_mode_change(problem, values, problem.terms(probe)), before, after, strict=True):
        change, seen = (r1 - r0)[problem.usable], estimate[problem.usable]
        assert np.linalg.norm(seen - change) < 0.3 * np.linalg.norm(change)
