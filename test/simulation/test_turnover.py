"""How dry friction turns over at a reversal, against closed forms and against its own limits."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate

from flex_ident.simulation.turnover import as_sampled, friction_share

Floats = NDArray[np.float64]
RATE = 1000.0


def swing(frequency_hz: float = 1.3) -> tuple[Floats, Floats, Floats]:
    """Velocity, its change within half a sample, and position of a swing of ±0.1 rad."""
    t = np.arange(4000) / RATE
    omega = 2.0 * np.pi * frequency_hz
    velocity = 0.1 * omega * np.cos(omega * t)
    half_width = np.maximum(np.abs(0.1 * omega**2 * np.sin(omega * t)) * 0.5 / RATE, 1e-9)
    return velocity, half_width, 0.1 * np.sin(omega * t)


def test_coulomb_friction_is_the_mean_of_its_sign_over_the_sample() -> None:
    velocity, half_width, position = swing()
    share = friction_share(velocity, half_width, position)
    steps = np.linspace(-1.0, 1.0, 4001)
    mean = np.sign(velocity[:, None] + half_width[:, None] * steps).mean(axis=1)
    np.testing.assert_allclose(share, mean, atol=1e-3)
    assert 0 < np.count_nonzero(np.abs(share) < 1.0) < 30


def test_speed_grows_friction_with_the_mean_of_tanh_over_the_sample() -> None:
    velocity, half_width, position = swing()
    speed = 0.02
    share = friction_share(velocity, half_width, position, speed=speed)
    steps = np.linspace(-1.0, 1.0, 4001)
    grown = np.tanh((velocity[:, None] + half_width[:, None] * steps) / speed)
    np.testing.assert_allclose(share, integrate.trapezoid(grown, steps, axis=1) / 2.0, atol=1e-6)


@pytest.mark.parametrize("law", ["speed", "way"])
def test_a_law_that_acts_at_once_is_coulombs(law: str) -> None:
    velocity, half_width, position = swing()
    step = friction_share(velocity, half_width, position)
    away = []
    for size in (1e-3, 1e-5, 1e-7):
        away.append(float(np.mean(np.abs(friction_share(velocity, half_width, position, **{law: size}) - step))))
    assert away[0] > away[1] > away[2]
    assert away[2] < 1e-3


@pytest.mark.parametrize("every", [1, 7])
def test_way_is_dahls_closed_form_however_it_is_sampled(every: int) -> None:
    """After a reversal from full friction z = 1 - 2 exp(-s / way), s the way since then."""
    way = 3e-3
    forth = np.concatenate((np.linspace(0.05, 0.0, 500), np.linspace(0.0, 0.05, 501)[1:]))
    velocity = np.gradient(forth) * RATE
    velocity[499] = -1e-3  # the sample of the reversal still goes down
    share = friction_share(velocity, np.full(velocity.size, 1e-6), forth, way=way)
    back = slice(500, None, every)
    np.testing.assert_allclose(share[back], 1.0 - 2.0 * np.exp(-forth[back] / way), atol=1e-6)
    coarse = forth[499::every]
    alone = friction_share(
        np.concatenate(([-1.0], np.ones(coarse.size - 1))), np.full(coarse.size, 1e-6), coarse, way=way
    )
    np.testing.assert_allclose(alone, share[499::every], atol=1e-6)


@pytest.mark.parametrize("lead", [3.0, -2.0, 0.5])
def test_lead_shifts_the_turnover_by_so_many_samples(lead: float) -> None:
    velocity, half_width, position = swing()
    plain = friction_share(velocity, half_width, position)
    share = friction_share(velocity, half_width, position, lead=lead)
    at = np.arange(plain.size, dtype=float)
    np.testing.assert_allclose(share, np.interp(at + lead, at, plain))
    turns = np.flatnonzero((plain[:-1] > 0.0) & (plain[1:] <= 0.0))
    led = np.flatnonzero((share[:-1] > 0.0) & (share[1:] <= 0.0))
    assert np.mean(turns - led) == pytest.approx(lead, abs=0.6)


def test_share_stays_within_one() -> None:
    rng = np.random.default_rng(0)
    position = np.cumsum(rng.normal(0.0, 1e-3, 3000))
    velocity = np.gradient(position) * RATE
    half_width = np.abs(rng.normal(0.0, 0.1, 3000)) + 1e-9
    for way, speed, lead in ((0.0, 0.5, 1.0), (1e-3, 0.0, -1.0), (1e-3, 0.3, 2.5)):
        share = friction_share(velocity, half_width, position, speed=speed, way=way, lead=lead)
        assert float(np.max(np.abs(share))) <= 1.0


def test_what_a_mean_over_the_sample_takes_off_is_put_back() -> None:
    t = np.arange(2000) / RATE
    omega = 2.0 * np.pi * 60.0
    mean = np.sin(omega * t) * np.sinc(60.0 / RATE)
    left = np.max(np.abs(as_sampled(mean) - np.sin(omega * t))[1:-1])
    assert left < 0.05 * np.max(np.abs(mean - np.sin(omega * t)))
