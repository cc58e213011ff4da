"""The plant against formulas: what it conserves, where it rests, when it sticks, how it rings."""

import numpy as np
import pytest

from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import COBOT_JOINT
from flex_ident.virtual_joint.physics import GRAVITY, plant_values
from flex_ident.virtual_joint.plant import elastic_torque, state_at_rest, stepped

H = 1e-4
FREE = JointModel({"Jm": 1.5, "K": 4000.0, "JL": 0.7, "MX": 0.5, "MY": 3.0})


def moved(model: JointModel, state: np.ndarray, torque: float, seconds: float, *, every: int = 1) -> np.ndarray:
    """States (n, STATE) under a constant motor torque."""
    p = plant_values(model)
    states = []
    for k in range(round(seconds / H)):
        if k % every == 0:
            states.append(state.copy())
        stepped(p, state, torque, H, 1.0)
    return np.array(states)


def frequency_hz(values: np.ndarray, seconds: float) -> float:
    """Frequency of an undamped oscillation (n,), from its upward crossings of its mean."""
    values = values - 0.5 * (values.min() + values.max())
    up = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    at = up - values[up] / (values[up + 1] - values[up])
    return float((at.size - 1) / (at[-1] - at[0]) * values.size / seconds)


def test_energy_is_conserved_without_friction() -> None:
    state = state_at_rest(plant_values(FREE), 0.0, 0.0)
    state[0] += 0.02
    state[3] = 1.0
    s = moved(FREE, state, 0.0, 8.0, every=7)
    weight = GRAVITY * (0.5 * np.sin(s[:, 2]) - 3.0 * np.cos(s[:, 2]))
    energy = 0.75 * s[:, 1] ** 2 + 0.35 * s[:, 3] ** 2 + 2000.0 * (s[:, 0] - s[:, 2]) ** 2 + weight
    assert np.ptp(energy) < 2e-3 * np.ptp(weight)
    assert abs(np.mean(energy[-1000:]) - np.mean(energy[:1000])) < 1e-4 * np.ptp(weight)


def test_free_resonance_is_the_formulas() -> None:
    model = FREE.without(("MX", "MY"))
    state = state_at_rest(plant_values(model), 0.0, 0.0)
    state[0] += 0.01
    s = moved(model, state, 0.0, 3.0)
    expected = np.sqrt(4000.0 * (1 / 1.5 + 1 / 0.7)) / (2 * np.pi)
    assert frequency_hz(s[:, 0] - s[:, 2], 3.0) == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize(
    "effects",
    [{}, {"backlash": {"gap": 0.003}}, {"nonlinear_stiffness": {"cubic": 4e7}}, {"gravity": {"MX": 1.0}},
     {"kinematic_error": {"amplitude": 1e-3, "cycles_per_turn": 40.0, "phase": 0.3}}],
)  # fmt: skip
@pytest.mark.parametrize("motor", [-1.0, 0.0, 0.7])
def test_at_rest_the_spring_carries_the_weight(effects: dict[str, dict[str, float]], motor: float) -> None:
    model = JointModel(FREE.parameters, effects)
    p = plant_values(model)
    state = state_at_rest(p, motor, motor)
    link = state[2]
    weight = GRAVITY * ((0.5 + model.value("gravity.MX")) * np.cos(link) + 3.0 * np.sin(link))
    assert elastic_torque(p, state[7], 0.0) == pytest.approx(weight, abs=1e-6)
    gear = 1.0 + 0.04 * np.cos(40.0 * motor + 0.3) if "kinematic_error" in effects else 1.0
    later = moved(model, state, gear * weight, 0.2)
    assert abs(later[-1, 0] - motor) < 1e-6


def test_sag_under_gravity_is_load_over_stiffness() -> None:
    state = state_at_rest(plant_values(COBOT_JOINT), 0.4, 0.4)
    load = GRAVITY * (0.5 * np.cos(state[2]) + 3.0 * np.sin(state[2]))
    assert 0.4 - state[2] == pytest.approx(load / 1e4, rel=1e-9)


def test_a_mass_sticks_until_pushed_harder_than_its_friction() -> None:
    model = JointModel({"J": 2.0, "FS": 3.0})
    still = moved(model, state_at_rest(plant_values(model), 0.0, 0.0), 2.999, 1.0)
    assert np.all(still[:, 0] == 0.0)
    loose = moved(model, state_at_rest(plant_values(model), 0.0, 0.0), 5.0, 1.0)
    assert loose[-1, 1] == pytest.approx((5.0 - 3.0) / 2.0, rel=1e-3)


def test_the_link_sticks_while_the_motor_moves() -> None:
    model = JointModel({"Jm": 1.0, "K": 1000.0, "JL": 1.0, "FVm": 200.0, "FS": 2.0})
    s = moved(model, state_at_rest(plant_values(model), 0.0, 0.0), 1.9, 2.0)
    assert np.all(s[:, 2] == 0.0)
    assert s[-1, 0] == pytest.approx(1.9e-3, rel=1e-3)


def test_coulomb_friction_stops_a_mass_where_its_energy_ends() -> None:
    model = JointModel({"J": 2.0, "FS": 3.0})
    state = state_at_rest(plant_values(model), 0.0, 0.0)
    state[1] = 1.0
    s = moved(model, state, 0.0, 1.0)
    assert s[-1, 1] == 0.0
    assert s[-1, 0] == pytest.approx(0.5 * 2.0 / 3.0, rel=1e-3)


@pytest.mark.parametrize("key", ["Jm", "K", "JL"])
def test_a_joint_without_mass_or_spring_is_refused(key: str) -> None:
    with pytest.raises(ConfigurationError, match=f"{key} of the virtual joint is 0.0"):
        plant_values(COBOT_JOINT.without((key,)))
