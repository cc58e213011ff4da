"""Lost samples told from late ones."""

import numpy as np
import pytest

from flex_ident.recording.instants import evened, grid_index, period_of

PERIOD = 2e-3


def test_lost_samples_are_counted() -> None:
    index = np.delete(np.arange(5000), [100, 101, 102, 700, 4000, 4500, 4501])
    time = PERIOD * index + 0.05 * PERIOD * np.random.default_rng(0).standard_normal(index.size)
    np.testing.assert_array_equal(grid_index(time, period_of(time)), index)


@pytest.mark.parametrize("percent", [0.0, 0.2, 2.0])
def test_late_samples_are_not_lost_ones(percent: float) -> None:
    """Messages wait up to ten periods for the network, then arrive at once; some are lost besides."""
    random = np.random.default_rng(1)
    index = np.flatnonzero(random.random(20_000) > percent / 100.0)
    index[0], index[-1] = 0, 19_999
    latency = random.exponential(0.1 * PERIOD, index.size)
    for stall in range(300, index.size - 20, 900):
        held = np.arange(stall, stall + int(random.integers(2, 10)))
        latency[held] += PERIOD * (held[-1] - held + 1)
    received = np.maximum.accumulate(PERIOD * index + latency) + 1e-9 * np.arange(index.size)
    found = grid_index(received, period_of(received))
    assert period_of(received) == pytest.approx(PERIOD, rel=2e-4)
    assert np.mean(found - index == np.round(np.median(found - index))) > 0.98
    even = evened(received)
    wrong = even - PERIOD * index
    assert np.std(wrong - np.median(wrong)) < 0.1 * PERIOD


def test_bursts_are_spread_out() -> None:
    """A driver that hands over ten samples at a time."""
    index = np.arange(10_000)
    received = PERIOD * (index // 10 * 10 + 9) + 2e-5 * (index % 10)
    assert period_of(received) == pytest.approx(PERIOD, rel=1e-3)
    wrong = evened(received) - PERIOD * index
    assert np.ptp(wrong) < 0.1 * PERIOD
    np.testing.assert_array_equal(grid_index(received, PERIOD), index)


def test_times_without_a_grid_are_left_as_they_are() -> None:
    received = np.cumsum(np.random.default_rng(2).exponential(PERIOD, 5000))
    np.testing.assert_array_equal(evened(received), received)


def test_long_gap_is_no_matter_of_counting() -> None:
    """Over a long gap the grid may shift: each side is laid on its own."""
    index = np.arange(4000)
    time = PERIOD * index + np.where(index < 2000, 0.0, 7.0 + 0.4 * PERIOD)
    np.testing.assert_allclose(evened(time), time, atol=1e-6)
