"""Bristles exact in the way moved: LuGre's equation integrated finely in time says the same."""

from __future__ import annotations

import numpy as np
import pytest

from flex_ident.simulation.bristles import bristle_torque

RATE = 1000.0


def integrated(stiffness: float, level: float, excess: float, speed: float) -> tuple[np.ndarray, ...]:
    """Velocity, position and friction (n,) at `RATE`: LuGre's bristles by steps of 10 microseconds, midpoint rule."""
    fine = 1e-5
    t = np.arange(0.0, 2.0, fine)
    v = 0.2 * np.cos(2.0 * np.pi * t) + 0.05 * np.cos(2.0 * np.pi * 7.0 * t + 1.0)
    q = np.concatenate(([0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * fine)))
    g = level + excess * np.exp(-((v / speed) ** 2))
    f = np.empty(t.size)
    f[0] = np.sign(v[0]) * g[0]
    for k in range(1, t.size):
        half = f[k - 1] + 0.5 * fine * stiffness * (v[k - 1] - abs(v[k - 1]) * f[k - 1] / g[k - 1])
        f[k] = f[k - 1] + fine * stiffness * (v[k] - abs(v[k]) * half / g[k])
    every = round(1.0 / RATE / fine)
    return v[::every], q[::every], f[::every], g[::every]


@pytest.mark.parametrize("excess", [0.0, 3.0])
def test_torque_is_that_of_fine_steps_in_time(excess: float) -> None:
    v, q, f, g = integrated(2e4, 6.0, excess, 0.05)
    found = bristle_torque(np.sign(v), g, q, 2e4)
    assert np.std(found - f) < 0.02 * np.std(f)
    assert np.std(np.sign(v) * g - f) > 0.1 * np.std(f)  # and Coulomb's law does not


def test_however_stiff_it_never_overshoots() -> None:
    v, q, _, g = integrated(2e4, 6.0, 3.0, 0.05)
    found = bristle_torque(np.sign(v), g, q, 1e12)
    assert np.isfinite(found).all()
    assert (np.abs(found) <= np.max(g) + 1e-12).all()
    moving = np.abs(v) > 0.02
    assert np.max(np.abs(found - np.sign(v) * g)[moving]) < 1e-6


def test_at_standstill_the_torque_stays() -> None:
    q = np.concatenate((np.linspace(0.0, 1e-4, 50), np.full(50, 1e-4)))
    direction = np.concatenate((np.ones(50), np.zeros(50)))
    found = bristle_torque(direction, np.full(100, 5.0), q, 2e4)
    assert (found[50:] == found[50]).all()
    assert found[50] == pytest.approx(5.0)
