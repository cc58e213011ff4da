"""Left-out costs on a linear problem, where leaving out and fitting again is the known answer."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up import linear_fit, white
from scipy.signal import lfilter

from flex_ident.likelihood.comparison import (
    BLOCK_S,
    FOLD_S,
    FOLDS,
    correlation_factor,
    held_out_comparison,
    left_out_costs,
    log_likelihood_gain,
)

COUNT, STEP = 1500, 0.01
TIME = np.arange(COUNT) * STEP
PROBLEM: Any = SimpleNamespace(time=TIME)


def columns(seed: int = 0) -> np.ndarray:
    """Three columns of very different sizes."""
    return np.random.default_rng(seed).standard_normal((COUNT, 3)) * np.array([1e-3, 1.0, 1e4])


def target(matrix: np.ndarray, seed: int = 1) -> np.ndarray:
    return matrix @ np.array([2e3, -1.0, 3e-4]) + white(seed, COUNT)


@pytest.mark.parametrize("prior", [None, np.array([1e-6, 40.0, 0.0])])
def test_left_out_costs_are_those_of_fits_that_did_not_see_them(prior: np.ndarray | None) -> None:
    matrix = columns()
    y = target(matrix)
    costs = left_out_costs(PROBLEM, linear_fit(matrix, y, prior=prior))
    folds, blocks = (TIME / FOLD_S).astype(int) % FOLDS, (TIME / BLOCK_S).astype(int)
    information = np.diag(np.zeros(3) if prior is None else prior)
    expected = np.zeros(blocks.max() + 1)
    for fold in range(FOLDS):
        seen = folds != fold
        part = matrix[seen]
        x = np.linalg.solve(part.T @ part + information, part.T @ y[seen])
        np.add.at(expected, blocks[~seen], (y - matrix @ x)[~seen] ** 2)
    np.testing.assert_allclose(costs, expected, rtol=1e-6)


def test_what_only_the_left_out_part_tells_is_not_made_up() -> None:
    matrix = columns()
    matrix[:, 2] *= (TIME / FOLD_S).astype(int) % FOLDS == 2
    y = target(matrix)
    y[(TIME / FOLD_S).astype(int) % FOLDS == 2] += 30.0
    costs = left_out_costs(PROBLEM, linear_fit(matrix, y))
    assert np.isfinite(costs).all()
    assert costs.sum() < 3.0 * float(np.sum(y**2))


def test_a_column_that_is_there_is_kept_and_noise_is_not() -> None:
    matrix = columns()
    there, noise = white(5, COUNT), white(6, COUNT)
    y = target(matrix) + 0.3 * there
    before = linear_fit(matrix, y)
    kept = held_out_comparison(PROBLEM, before, linear_fit(np.column_stack((matrix, there)), y))
    made_up = held_out_comparison(PROBLEM, before, linear_fit(np.column_stack((matrix, noise)), y))
    assert kept.t > 4.0
    assert kept.share == pytest.approx(0.3**2 / (1.0 + 0.3**2), abs=0.03)
    assert made_up.t < 1.0
    assert made_up.share < 0.003


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.9])
def test_correlated_residuals_hold_fewer_samples(rho: float) -> None:
    """For a first-order autoregression the sum over squared correlations is 1 + 2 rho^2 / (1 - rho^2)."""
    x = np.asarray(lfilter([1.0], [1.0, -rho], white(2, 60000)))
    fit = linear_fit(np.ones((x.size, 1)), x)
    assert correlation_factor(fit) == pytest.approx(1.0 + 2.0 * rho**2 / (1.0 - rho**2), rel=0.1)


def test_gain_is_the_saved_sum_of_squares_where_the_noise_is_known() -> None:
    matrix = columns()
    y = 0.9 * target(matrix) + 0.2 * white(5, COUNT)
    before, after = linear_fit(matrix, y), linear_fit(np.column_stack((matrix, white(5, COUNT))), y)
    assert after.residual @ after.residual < COUNT
    saved = float(before.residual @ before.residual - after.residual @ after.residual)
    gain = log_likelihood_gain(before, after)
    assert 0.0 < gain <= saved
    assert log_likelihood_gain(before, before) == 0.0
