"""Gravity that is in the effort or not, from the motor alone: plants of `bench`, which are not the estimator's."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from flex_ident.estimation.identification import identify
from flex_ident.estimation.kind_priors import largest_moment
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.estimation.thresholds import STEEL, WIDEST_M

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from plants import case_of, made
from recordings import recording_of

GRAVITY = 9.81


@pytest.mark.parametrize("inertia", [1e-4, 2.2, 60.0])
def test_the_largest_moment_is_that_of_a_steel_cylinder_at_its_best_distance(inertia: float) -> None:
    def moment(log_mass: float) -> float:
        mass = np.exp(log_mass)
        own = mass**2 / (2.0 * np.pi * STEEL * WIDEST_M)
        return -mass * np.sqrt(max(inertia - own, 0.0) / mass)

    best = minimize_scalar(moment, bounds=(-12.0, 12.0), method="bounded", options={"xatol": 1e-9})
    assert largest_moment(inertia) == pytest.approx(-best.fun, rel=1e-6)


@pytest.mark.campaign
def test_an_absurd_weight_is_no_rival_to_gravity_in_the_effort() -> None:
    plant = made(case_of(61, 38))
    result = identify(recording_of(plant.recorded, "motor"), IdentifyOptions(sensors="motor"))
    assert result.verdict == "trusted"
    assert result.parameter("K").relative_std_percent < 0.1
    for key in ("Jm", "K", "JL"):
        assert abs(result.parameter(key).value - plant.truth[key]) < 3.0 * result.parameter(key).std


@pytest.mark.campaign
def test_a_fit_that_stalls_behind_a_lag_is_not_taken_for_an_effort_less_gravity() -> None:
    plant = made(case_of(577, 4))
    result = identify(recording_of(plant.recorded, "motor+link"), IdentifyOptions())
    assert result.verdict == "trusted"
    for parameter in result.parameters:
        if parameter.key in plant.truth:
            assert abs(parameter.value - plant.truth[parameter.key]) < 3.0 * parameter.std, parameter


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("index", [1, 3])
def test_over_a_wide_range_a_compensated_effort_is_not_taken_for_the_whole(index: int) -> None:
    plant = made(case_of(62, index))
    recording, truth = recording_of(plant.recorded, "motor"), plant.truth
    position = recording.motor_position
    added = GRAVITY * (truth["MX"] * np.cos(position) + truth["MY"] * np.sin(position))
    result = identify(replace(recording, motor_torque=recording.motor_torque - added), IdentifyOptions(sensors="motor"))
    for key in ("Jm", "K", "JL"):
        assert abs(result.parameter(key).value - truth[key]) < 3.0 * result.parameter(key).std
