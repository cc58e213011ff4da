"""The band in which a recording says something about the joint."""

import numpy as np
import pytest

from flex_ident.filtering.band import excited_band_hz
from flex_ident.recording import Recording

RATE_HZ, SECONDS = 250.0, 40.0
TIME = np.arange(int(RATE_HZ * SECONDS)) / RATE_HZ


def recording(lines_hz: np.ndarray, *, noise: float = 1e-3, seed: int = 0) -> Recording:
    """An inertia of 1 kg m^2 under a torque of lines of 1 N m each."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0.0, 2.0 * np.pi, lines_hz.size)
    angle = 2.0 * np.pi * lines_hz[:, None] * TIME + phase[:, None]
    torque = np.sin(angle).sum(axis=0)
    position = (-np.sin(angle) / (2.0 * np.pi * lines_hz[:, None]) ** 2).sum(axis=0)
    return Recording("j", RATE_HZ, position, torque + noise * rng.standard_normal(TIME.size))


@pytest.mark.parametrize("highest_hz", [8.0, 14.0, 30.0])
def test_lines_of_a_multisine_are_excitation_however_far_apart(highest_hz: float) -> None:
    lines = np.unique(np.round(np.geomspace(0.3, highest_hz, 25) * SECONDS)) / SECONDS
    assert excited_band_hz(recording(lines)) == pytest.approx(lines[-1], abs=1.0)


def test_noise_between_and_above_lines_is_none() -> None:
    found = excited_band_hz(recording(np.array([0.5, 1.0, 2.0, 4.0]), noise=0.3))
    assert found < 7.0


def test_a_dense_sweep_ends_where_it_ends() -> None:
    lines = np.arange(1, int(20.0 * SECONDS)) / SECONDS
    assert excited_band_hz(recording(lines, noise=0.1)) == pytest.approx(20.0, abs=2.0)
