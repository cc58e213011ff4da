"""The direction of motion at reversals with dry friction, against a motion in closed form."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate

from flex_ident.filtering.direction import KINK_ROUNDED, sharp_velocity
from flex_ident.filtering.spectral import lowpass_response

Floats = NDArray[np.float64]
RATE, JUMP = 500.0, 6.0
"""Samples per s; dry friction over inertia, rad/s^2."""


def rubbed(frequency_hz: float, amplitude: float, noise: float = 0.0) -> tuple[Floats, Floats]:
    """Time and position (n,) of a mass under a sinusoidal force and dry friction that reverses at each k / 2f.

    Its velocity is V sin(w t + phase) + JUMP tri(t), tri a triangle of slope -1 while the mass moves up, 1 while down.
    """
    t = np.arange(8000) / RATE
    w = 2.0 * np.pi * frequency_hz
    phase = -np.arcsin(JUMP * 0.5 * np.pi / w / amplitude)
    half = np.pi / w
    into = np.mod(t, half)
    up = np.where(np.mod(np.floor(t / half + 1e-12), 2.0) == 0.0, 1.0, -1.0)
    position = -amplitude / w * np.cos(w * t + phase) + JUMP * up * (0.5 * half * into - 0.5 * into**2)
    return t, position + noise * np.random.default_rng(1).standard_normal(t.size)


def late(t: Floats, velocity: Floats, frequency_hz: float) -> float:
    """By how much, s, the zero crossings of a velocity are late on average."""
    turns = np.flatnonzero(velocity[:-1] * velocity[1:] < 0.0)
    turns = turns[(t[turns] > 1.0) & (t[turns] < t[-1] - 1.0)]
    at = t[turns] + velocity[turns] / (velocity[turns] - velocity[turns + 1]) / RATE
    half = 0.5 / frequency_hz
    return float(np.mean(at - half * np.round(at / half)))


def test_mean_distance_of_the_low_pass() -> None:
    x = np.linspace(1e-6, 60.0, 400001)
    lost = (1.0 - lowpass_response(x, 1.0)) / x**2
    whole = integrate.trapezoid(lost, x) + 1.0 / 60.0  # beyond, nothing is left
    assert pytest.approx(whole / np.pi**2, rel=1e-4) == KINK_ROUNDED


@pytest.mark.parametrize(("frequency_hz", "amplitude"), [(8.0, 0.4), (15.0, 0.3), (25.0, 0.3)])
def test_a_reversal_is_put_back_where_it_was(frequency_hz: float, amplitude: float) -> None:
    t, position = rubbed(frequency_hz, amplitude)
    sharp = sharp_velocity(position, RATE, lowest_hz=90.0)
    moved = late(t, sharp.velocity, frequency_hz)
    mended = late(t, sharp.velocity + sharp.kink(JUMP), frequency_hz)
    assert abs(moved) > 5e-5
    assert abs(mended) < 0.25 * abs(moved)


def test_a_low_pass_of_less_takes_more_off() -> None:
    _, position = rubbed(15.0, 0.3, noise=3e-5)
    low, high = (sharp_velocity(position, RATE, lowest_hz=cutoff) for cutoff in (45.0, 150.0))
    assert np.max(low.kink(JUMP)) > 1.2 * np.max(high.kink(JUMP)) > 0.0


def test_friction_that_turns_over_slowly_loses_less() -> None:
    _, position = rubbed(15.0, 0.3)
    sharp = sharp_velocity(position, RATE, lowest_hz=90.0)
    step, speed, way = (float(np.max(np.abs(sharp.kink(JUMP, **law)))) for law in ({}, {"speed": 0.1}, {"way": 1e-3}))
    assert speed < 0.5 * step
    assert way < 0.5 * step
    assert sharp.kink(0.0).max() == 0.0


def test_a_joint_that_never_turns_has_no_kink() -> None:
    sharp = sharp_velocity(np.linspace(0.0, 5.0, 2000), RATE, lowest_hz=30.0)
    assert not sharp.rounding[200:-200].any()
