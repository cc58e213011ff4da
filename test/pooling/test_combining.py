"""One number from several: what the intervals cover, whatever the scatter between recordings."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import KEYS, TRUTH, members

from flex_ident.pooling.combining import between, pooled, pooled_all, pooled_covariance
from flex_ident.pooling.members import side_by_side
from flex_ident.pooling.several import several

DRAWS = 1500


def covered(count: int, ratio: float, seed: int = 0) -> tuple[float, float]:
    """Percent of intervals that hold the truth, and their median half width, for a scatter of `ratio` own stds."""
    rng = np.random.default_rng((seed, count, int(10 * ratio)))
    hits, halves = 0, []
    for _ in range(DRAWS):
        stds = np.exp(rng.uniform(-0.7, 0.7, count))
        found = pooled(rng.normal(0.0, np.hypot(ratio, stds)), stds)
        hits += abs(found.value) <= found.half
        halves.append(found.half)
    return 100.0 * hits / DRAWS, float(np.median(halves))


@pytest.mark.parametrize("ratio", [0.0, 1.0, 3.0, 10.0, 30.0])
@pytest.mark.parametrize("count", [3, 5, 10])
def test_intervals_cover_whatever_the_scatter(count: int, ratio: float) -> None:
    percent, _ = covered(count, ratio)
    assert 93.0 <= percent <= 100.0
    assert percent <= 99.0 or ratio < 2.0


@pytest.mark.parametrize("ratio", [0.0, 1.0, 3.0, 5.0, 10.0])
def test_two_that_agree_are_not_blown_up_and_two_that_do_not_still_cover(ratio: float) -> None:
    percent, half = covered(2, ratio)
    assert percent >= 89.0
    assert ratio > 0.0 or half < 4.0


def test_scatter_is_found_to_its_size_and_chance_says_when_there_is_none() -> None:
    rng = np.random.default_rng(3)
    stds = np.full(200, 0.1)
    loose = pooled(rng.normal(5.0, 0.3, 200) + rng.normal(0.0, 0.1, 200), stds)
    assert loose.scatter == pytest.approx(0.3, rel=0.12)
    assert loose.chance < 1e-12
    tight = [pooled(rng.normal(5.0, 0.1, 10), np.full(10, 0.1)).chance < 0.05 for _ in range(1000)]
    assert 0.02 < np.mean(tight) < 0.08
    assert between(np.array([1.0, 1.01, 0.99]), np.full(3, 1.0)) == 0.0


def test_what_the_method_gets_wrong_everywhere_is_not_averaged_away() -> None:
    values, stds = np.full(100, 2.0), np.full(100, 0.1)
    assert pooled(values, stds).std < 0.02
    found = pooled(values, stds, np.full(100, 0.08))
    assert found.std >= 0.08
    assert found.std < 0.1


def test_one_is_what_it_is() -> None:
    found = pooled(np.array([3.0]), np.array([0.2]))
    assert (found.value, found.std, found.scatter) == (3.0, pytest.approx(0.2), 0.0)


def test_the_covariance_is_that_of_the_means_over_many_draws() -> None:
    rng = np.random.default_rng(5)
    means, matrices = [], []
    for _ in range(400):
        together = rng.normal(0.0, 0.03, (10, 1)) * np.array([0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
        given = side_by_side(members(rng, 10, scatter=together))
        found = pooled_all(given)
        means.append([own.value for own in found])
        matrices.append(pooled_covariance(given, found))
    assert given.keys == KEYS
    true = np.cov(np.array(means).T) / np.outer(TRUTH, TRUTH)
    stated = np.mean(matrices, axis=0) / np.outer(TRUTH, TRUTH)
    ratio = np.sqrt(np.diag(stated) / np.diag(true))
    assert np.all((ratio > 0.9) & (ratio < 1.6))
    k, fs = KEYS.index("K"), KEYS.index("FSm")
    scale = np.sqrt(np.diag(stated))
    assert stated[k, fs] / scale[k] / scale[fs] > 0.3  # both follow one thing: half of that is believed of ten
    assert np.min(np.linalg.eigvalsh(np.mean(matrices, axis=0) / np.outer(scale, scale))) > 0.0


def test_what_scatters_by_more_than_its_size_is_not_identifiable() -> None:
    """MY of two recordings with opposite signs was `identifiable` at 0.1 ± 31."""
    apart = np.zeros((2, len(KEYS)))
    apart[1, KEYS.index("MY")] = -2.0
    apart[1, KEYS.index("K")] = 0.01
    found = {p.key: p for p in several(members(np.random.default_rng(8), 2, scatter=apart)).parameters}
    assert not found["MY"].identifiable
    assert found["K"].identifiable


def test_what_hardly_matters_in_each_recording_may_be_known_badly() -> None:
    drawn = members(np.random.default_rng(9), 3)
    few = [
        replace(m, parameters=tuple(replace(p, value=0.1 * p.std) if p.key == "MX" else p for p in m.parameters))
        for m in drawn
    ]
    found = {p.key: p for p in several(few).parameters}
    assert found["MX"].std > 0.3 * abs(found["MX"].value)
    assert found["MX"].identifiable
