"""Trapezoidal moves with rests, in which the motor sticks while the link rings: a plant with set-valued friction."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.recording import Floats, Recording

RATE_HZ, STEPS, SECONDS = 200.0, 100, 15.0
TRUTH = {
    "Jm": 0.8, "K": 900.0, "JL": 0.5, "FVm": 5.0, "FSm": 2.5, "FV": 0.4, "FS": 0.3, "MX": 0.2, "MY": 1.0,
}  # fmt: skip


def moves(seed: int) -> Floats:
    """Speeds of the motor, rad/s: up in 0.15 s, constant, down, and a rest; to and fro."""
    random, dt = np.random.default_rng(seed), 1.0 / (RATE_HZ * STEPS)
    speed, way = [np.zeros(round(0.3 / dt))], 0.0
    while sum(map(len, speed)) < SECONDS / dt:
        top, length = random.uniform(1.0, 2.5), random.uniform(0.15, 0.5)
        ahead = -math.copysign(1.0, way) if abs(way) > 0.5 else random.choice([-1.0, 1.0])
        ramp = np.linspace(0.0, 1.0, round(0.15 / dt))
        pulse = ahead * top * np.concatenate((ramp, np.ones(round(length / dt)), ramp[::-1]))
        speed += [pulse, np.zeros(round(random.uniform(0.2, 0.6) / dt))]
        way += float(pulse.sum()) * dt
    return np.concatenate(speed)[: round(SECONDS / dt)]


def recorded(seed: int) -> Recording:
    """The motor's position and torque in such moves, with noise of both."""
    p, dt, speed = TRUTH, 1.0 / (RATE_HZ * STEPS), moves(seed)
    motor = np.cumsum(speed) * dt
    link = np.empty_like(motor)
    q = v = 0.0
    for k, at in enumerate(motor.tolist()):
        drive = p["K"] * (at - q) - 9.81 * (p["MX"] * math.cos(q) + p["MY"] * math.sin(q)) - p["FV"] * v
        free = v + drive / p["JL"] * dt  # then friction takes of it what it can
        most = p["FS"] / p["JL"] * dt
        v = 0.0 if abs(free) <= most else free - math.copysign(most, free)
        q += v * dt
        link[k] = q
    spring = p["K"] * (motor - link)
    torque = p["Jm"] * np.gradient(speed, dt) + p["FVm"] * speed + p["FSm"] * np.sign(speed) + spring
    random = np.random.default_rng(seed + 1)
    n = round(SECONDS * RATE_HZ)
    read = motor[::STEPS][:n] + 1e-5 * random.standard_normal(n)
    return Recording("joint", RATE_HZ, read, torque[::STEPS][:n] + 0.2 * random.standard_normal(n))


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [3, pytest.param(6, marks=pytest.mark.campaign), pytest.param(8, marks=pytest.mark.campaign)]
)
def test_a_fit_goes_on_beyond_a_kink_of_the_links_friction(seed: int) -> None:
    result = identify(recorded(seed), IdentifyOptions())
    assert result.verdict != "rejected"
    for key, value in TRUTH.items():
        parameter = result.parameter(key)
        if parameter.identifiable:
            assert abs(parameter.value - value) < 3.5 * parameter.std, parameter
