"""The estimator's simulation with each effect predicts what a plant of its own, the virtual joint, does with it."""

from __future__ import annotations

import numpy as np
import pytest

from flex_ident.effects import CATALOGUE
from flex_ident.estimation.estimate import fit_problem
from flex_ident.likelihood.problem import values_of
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=16.0, sample_rate_hz=1000.0)
CLEAN = MeasurementChain(1e-9, 1e-9, 0.0, 0.0)
EFFECTS: dict[str, dict[str, float]] = {
    "stribeck_friction": {"amplitude": 3.0, "velocity": 0.1},
    "torque_offset": {"offset": 4.0},
    "viscous_asymmetry": {"coefficient": 2.0},
    "viscous_nonlinearity": {"coefficient": 3.0},
    "load_dependent_friction": {"coefficient": 0.05},
    "friction_drift": {"rate": 0.02, "rate_motor": -0.03},
    "nonlinear_stiffness": {"cubic": 4e8},
    "backlash": {"gap": 5e-4},
    "motor_encoder_error": {
        "amplitude": 2e-4, "cycles_per_turn": 80.0, "phase": 0.4,
        "amplitude_2": 1e-4, "cycles_per_turn_2": 160.0, "phase_2": 1.0,
    },
    "link_encoder_error": {
        "amplitude": 3e-4, "cycles_per_turn": 1.0, "phase": 0.9,
        "amplitude_2": 2e-4, "cycles_per_turn_2": 2.0, "phase_2": 0.2,
    },
    "viscoelastic_spring": {"stiffness": 1500.0, "time": 0.02},
    "soft_zone": {"share": 0.4, "deflection": 8e-4},
    "hysteresis": {"torque": 2.0, "deflection": 1e-3},
    "joint_damping": {"damping": 4.0},
    "torque_ripple": {
        "amplitude": 2.0, "cycles_per_turn": 80.0, "phase": 0.4,
        "amplitude_2": 1.5, "cycles_per_turn_2": 120.0, "phase_2": 1.4,
        "amplitude_5": 1.0, "cycles_per_turn_5": 40.0, "phase_5": 0.1,
    },
    "kinematic_error": {
        "amplitude": 2e-4, "cycles_per_turn": 80.0, "phase": 0.4,
        "amplitude_3": 1e-4, "cycles_per_turn_3": 50.0, "phase_3": 1.0,
    },
    "presliding_friction": {"deflection": 5e-4, "amplitude": 3.0, "velocity": 0.05},
    "mount_mode": {"inertia": 20.0, "stiffness": 8e4, "damping": 60.0},
    "position_dependent_friction": {
        "amplitude": 3.0, "cycles_per_turn": 30.0, "phase": 0.4,
        "amplitude_2": 1.0, "cycles_per_turn_2": 75.0, "phase_2": 1.0,
    },
    "cable_torque": {"stiffness": 30.0, "torque": 3.0, "cosine": 2.0, "sine": -4.0},
    "iron_saturation": {"loss": 4e-6},
    "torque_droop": {"loss": 0.05},
    "gain_drift": {"rate": 0.01},
    "offset_drift": {"rate": 0.2},
    "position_dependent_stiffness": {"cosine": -1500.0, "sine": 900.0},
    "time_delay": {"delay": 4e-3},
    "encoder_skew": {"skew": 4e-3},
    "effort_lag": {"time": 8e-3},
    "second_mode": {"inertia": 0.15, "stiffness": 3000.0, "damping": 0.5},
    "motor_friction_curve": {
        "speed_1": -1.5, "torque_1": -5.0, "speed_2": -0.6, "torque_2": 3.0, "speed_3": -0.1, "torque_3": 1.0,
        "speed_4": 0.1, "torque_4": -2.0, "speed_5": 0.7, "torque_5": 4.0, "speed_6": 1.6, "torque_6": -3.0,
    },
    "motor_angle_curve": {
        "angle_1": -0.05, "torque_1": 3.0, "angle_2": 0.0, "torque_2": -1.0, "angle_3": 0.03, "torque_3": 4.0,
    },
    "spring_curve": {
        "deflection_1": -6e-3, "torque_1": 6.0, "deflection_2": -2e-3, "torque_2": -2.0, "deflection_3": 3e-3,
        "torque_3": 4.0, "deflection_4": 6e-3, "torque_4": 9.0,
    },
}  # fmt: skip
WORST_PERCENT = 1.5
"""Difference between the two, of the torque and of the deflection: integrators, sticking, and the low-pass."""


OTHERS = {"presliding_friction": {"softness": 0.111, "time": 0.0095}}
"""Effects that have a second law."""


def difference_percent(name: str, *, known: bool, other: bool = False) -> float:
    """Largest relative difference over torque and deflection, the simulation with or without the effect."""
    own = OTHERS if other else EFFECTS
    truth = COBOT_JOINT.with_effect(name, own[name]) if name else COBOT_JOINT
    problem = fit_problem(virtual_recording(truth, EXPERIMENT, CLEAN, seed=0), sensors="motor+link")
    assert problem.link is not None
    rows = problem.usable
    torque, link = problem.residuals(values_of(truth if known else COBOT_JOINT))
    deflection = (problem.motion.position[:: problem.decimation] - problem.link)[rows]
    errors = (
        np.sqrt(np.mean(torque[rows] ** 2)) / np.std(problem.torque[rows]),
        np.std(link[rows]) / np.std(deflection),
    )
    return 100.0 * float(max(errors))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["", *EFFECTS])
def test_the_simulation_does_what_another_plant_does(name: str) -> None:
    assert difference_percent(name, known=True) < WORST_PERCENT


@pytest.mark.parametrize("name", list(OTHERS))
def test_a_second_law_likewise(name: str) -> None:
    apart = difference_percent(name, known=True, other=True)
    assert apart < WORST_PERCENT
    assert difference_percent(name, known=False, other=True) > 1.2 * apart


@pytest.mark.parametrize("name", list(EFFECTS))
def test_without_the_effect_it_does_not(name: str) -> None:
    assert difference_percent(name, known=False) > 1.2 * difference_percent(name, known=True)


def test_every_effect_is_here_or_has_a_test_of_its_own() -> None:
    assert set(CATALOGUE) - set(EFFECTS) == {"gravity", "saturation"}  # part of the joint; of the recording
