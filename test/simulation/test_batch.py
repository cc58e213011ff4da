"""Several sets of terms in one pass give what single simulations give, whatever effects they hold."""

from __future__ import annotations

import numpy as np
import pytest

from flex_ident.likelihood.problem import terms_of
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.motion import MotorMotion, motor_motion
from flex_ident.simulation.response import link_motion, link_motions
from flex_ident.virtual_joint import COBOT_JOINT, JOINTS

RATE = 500.0
EFFECTS: tuple[dict[str, float], ...] = (
    {"backlash.gap": 5e-4},
    {"hysteresis.torque": 2.0, "hysteresis.deflection": 1e-3},
    {"stribeck_friction.amplitude_link": 1.0, "stribeck_friction.velocity_link": 0.05},
    {"second_mode.inertia": 0.15, "second_mode.stiffness": 3000.0, "second_mode.damping": 0.5},
    {"kinematic_error.amplitude": 2e-4, "kinematic_error.cycles_per_turn": 80.0, "kinematic_error.phase": 0.4},
    {"load_dependent_friction.coefficient_link": 0.05, "friction_drift.rate": 0.05, "joint_damping.damping": 3.0},
    {"nonlinear_stiffness.cubic": 4e8, "viscous_asymmetry.coefficient_link": 0.5},
)  # fmt: skip


def motion() -> MotorMotion:
    """A sweep from standstill with a rest in the middle, so that the link sticks and reverses."""
    time = np.arange(0.0, 8.0, 1.0 / RATE)
    fade = np.clip(np.abs(time - 4.0) - 0.5, 0.0, 0.5) * 2.0
    return motor_motion(0.05 * fade * np.sin(2.0 * np.pi * time * (0.5 + time)), RATE, cutoff_hz=60.0, substeps=2)


def moved(values: Values) -> list[Floats]:
    """Terms of the model and of the same with each of its keys changed a little."""
    ways = [values, *(values | {key: value * 1.001} for key, value in values.items() if value)]
    return [terms_of(way, rigid=False) for way in ways]


def cases() -> list[tuple[str, dict[str, float]]]:
    """Every joint without an effect, and each effect in the cobot's, whose sizes they are."""
    return [*((joint, {}) for joint in JOINTS), *(("cobot", effect) for effect in EFFECTS)]


@pytest.mark.parametrize(("joint", "effect"), cases(), ids=lambda e: e if isinstance(e, str) else next(iter(e), ""))
def test_side_by_side_is_one_by_one(joint: str, effect: dict[str, float]) -> None:
    many = moved(Values({**JOINTS[joint].parameters, **effect}))
    for terms, together in zip(many, link_motions(many, motion()), strict=True):
        alone = link_motion(terms, motion())
        for name in ("spring_torque", "position", "velocity"):
            one, other = getattr(alone, name), getattr(together, name)
            assert np.max(np.abs(one - other)) < 1e-9 * np.max(np.abs(one))


@pytest.mark.parametrize("place", [0, 1, 2])
def test_links_far_apart_and_one_that_runs_away(place: int) -> None:
    good = terms_of(Values(COBOT_JOINT.parameters), rigid=False)
    steep = terms_of(Values({**COBOT_JOINT.parameters, "MY": -30.0, "initial_deflection": 0.5}), rigid=False)
    wild = terms_of(Values({**COBOT_JOINT.parameters, "K": 1e9, "JL": 1e-3}), rigid=False)
    many = [good, steep]
    many.insert(place, wild)
    found = link_motions(many, motion())
    assert not np.isfinite(found.pop(place).position).all()
    for terms, together in zip((good, steep), found, strict=True):
        alone = link_motion(terms, motion()).position
        assert np.max(np.abs(alone - together.position)) < 1e-9 * np.max(np.abs(alone))
