"""A joint that is held is told from one that moves, however small, slow or fast, and at any rate."""

import numpy as np
import pytest
from numpy.typing import NDArray

from flex_ident.recording.stillness import is_held

STEP = 2.0 * np.pi / 2**17
RATES = pytest.mark.parametrize("rate_hz", [5.0, 20.0, 100.0, 1000.0])


def rounded(position: NDArray[np.float64], step: float = STEP) -> NDArray[np.float64]:
    return np.round(position / step) * step


def time(rate_hz: float, duration_s: float = 30.0) -> NDArray[np.float64]:
    return np.arange(round(duration_s * rate_hz)) / rate_hz


@RATES
@pytest.mark.parametrize("counts", [1, 5, 20])
def test_encoder_noise_of_some_counts_is_no_motion(rate_hz: float, counts: int) -> None:
    n = time(rate_hz).size
    noise = np.random.default_rng(n + counts).integers(-counts, counts + 1, n)
    assert is_held(1.0 + STEP * noise)
    assert is_held(np.repeat(1.0 + STEP * noise, 3))  # published faster than it is read


@RATES
def test_a_last_digit_that_flickers_while_it_warms_up_is_no_motion(rate_hz: float) -> None:
    t = time(rate_hz)
    drift = 2.4 * STEP * (1.0 - np.exp(-t / 10.0))
    assert is_held(rounded(0.7 + drift + 0.3 * STEP * np.random.default_rng(1).standard_normal(t.size)))


@RATES
def test_noise_without_steps_that_was_interpolated_is_no_motion(rate_hz: float) -> None:
    t = time(rate_hz)
    noise = 1e-4 * np.random.default_rng(2).standard_normal(t.size)
    assert is_held(noise)
    assert is_held(np.interp(t + 0.37 / rate_hz, t, noise))


def test_a_position_that_never_changes_is_no_motion() -> None:
    assert is_held(np.full(1000, 0.3))
    assert is_held(np.full(1000, 0.3) + 1e-9 * np.arange(1000) / 1000)


@RATES
@pytest.mark.parametrize("amplitude", [20.0 * STEP, 0.01, 0.5])
def test_a_sine_is_motion(rate_hz: float, amplitude: float) -> None:
    t = time(rate_hz)
    noise = STEP * np.random.default_rng(3).standard_normal(t.size)
    for frequency_hz in (0.05, rate_hz / 20.0):
        assert not is_held(rounded(amplitude * np.sin(2.0 * np.pi * frequency_hz * t) + noise))


@RATES
def test_a_slow_creep_is_motion(rate_hz: float) -> None:
    assert not is_held(rounded(1e-3 * time(rate_hz) / 30.0))


def test_a_linear_chirp_to_near_half_the_rate_is_motion() -> None:
    t = time(100.0)
    assert not is_held(rounded(0.005 * np.sin(np.pi * 45.0 / 30.0 * t**2)))


def test_a_short_motion_in_a_long_rest_is_motion() -> None:
    t = time(100.0, 300.0)
    moved = np.where(np.abs(t - 150.0) < 2.0, 0.01 * np.sin(2.0 * np.pi * (t - 148.0)), 0.0)
    assert not is_held(rounded(moved + STEP * np.random.default_rng(4).standard_normal(t.size)))
