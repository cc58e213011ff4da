"""Steps in series of results: found where they are, and no more often where there are none than is promised."""

import numpy as np
import pytest

from flex_ident.pooling.changes import Step, adjusted, step
from flex_ident.pooling.scatter import Scatter, common_scatter
from flex_ident.pooling.series import Series
from flex_ident.pooling.thresholds import FALSE_CHANGES


def fleet(
    rng: np.random.Generator, *, results: tuple[int, int], scatter: float, apart: float = 0.0, freedom: float = np.inf
) -> list[Series]:
    """200 series without a step: each has a scatter of its own, and results that are known unequally well."""
    found = []
    for _ in range(200):
        n = int(rng.integers(*results))
        own = scatter * np.exp(apart * rng.normal())
        between = rng.normal(size=n) if np.isinf(freedom) else rng.standard_t(freedom, n) * np.sqrt(1 - 2 / freedom)
        stds = np.exp(0.2 * rng.normal(size=n))
        found.append(Series(100.0 + own * between + stds * rng.normal(size=n), stds, min(3, n - 1)))
    return found


def alarms(series: list[Series]) -> int:
    scatter = common_scatter(series)
    steps = [step(s, scatter) for s in series]
    return sum(p < FALSE_CHANGES for p in adjusted([s.chance for s in steps if s is not None]))


@pytest.mark.parametrize(
    "kind",
    [
        {"results": (12, 13), "scatter": 0.0}, {"results": (4, 8), "scatter": 3.0},
        {"results": (3, 16), "scatter": 3.0, "apart": 0.5}, {"results": (10, 11), "scatter": 3.0, "freedom": 4.0},
    ],
)  # fmt: skip
def test_false_alarms_are_as_rare_as_promised(kind: dict[str, float]) -> None:
    fleets = 15
    alarmed = sum(alarms(fleet(np.random.default_rng(seed), **kind)) > 0 for seed in range(fleets))
    assert alarmed <= 4  # 0.75 on average at 5 %; more than 4 in one of 1600 draws


def test_a_step_is_found_with_its_size_and_place() -> None:
    held = 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        series = fleet(rng, results=(10, 11), scatter=3.0)
        moved = series[0].values + np.where(np.arange(10) >= 6, 25.0, 0.0)
        series[0] = Series(moved, series[0].stds, 3)
        found = step(series[0], common_scatter(series))
        assert isinstance(found, Step)
        assert found.at in (5, 6, 7)
        assert 200 * found.chance < FALSE_CHANGES
        held += found.interval[0] <= 25.0 <= found.interval[1]
    assert held >= 16


def test_one_value_alone_is_no_step_and_can_be_asked_for() -> None:
    rng = np.random.default_rng(3)
    values = rng.normal(100.0, 1.0, 12)
    values[-1] += 20.0
    series = Series(values, np.ones(12), 3)
    found, newest = step(series, Scatter()), step(series, Scatter(), newest=True)
    assert found is not None
    assert newest is not None
    assert newest.chance < 1e-6 < found.chance
    assert newest.at == 11
    assert step(Series(values[:4], np.ones(4), 3), Scatter()) is None
    assert step(Series(values[:2], np.ones(2), 1), Scatter(), newest=True) is None


def test_what_is_known_badly_counts_less_and_what_is_stated_counts() -> None:
    values = np.array([1.0, 1.0, 1.0, 1.0, 9.0])
    sure = step(Series(values, np.full(5, 0.1), 2), Scatter(1.0, 5.0))
    unsure = step(Series(values, np.array([0.1, 0.1, 0.1, 0.1, 30.0]), 2), Scatter(1.0, 5.0))
    assert sure is not None
    assert unsure is not None
    assert abs(unsure.after - unsure.before) < 0.1 * abs(sure.after - sure.before)
    exact = step(Series(np.ones(6), np.full(6, 0.1), 2), Scatter(1e-9, 5.0))
    assert exact is not None
    assert exact.std >= 0.1 * np.sqrt(1 / 2 + 1 / 4) * 0.9
    assert exact.chance == 1.0


def test_adjusted_chances() -> None:
    assert adjusted([0.01, 0.04, 0.03, 0.5]) == pytest.approx([0.04, 0.16 / 3, 0.16 / 3, 0.5])
    assert adjusted([]) == []
    with pytest.raises(ValueError, match="baseline"):
        Series(np.ones(2), np.ones(2), 2)
