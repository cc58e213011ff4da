"""Levenberg and Marquardt within bounds against scipy's solvers."""

import numpy as np
import pytest
from scipy import optimize

from flex_ident.likelihood.minimising import _reduced, bounded_minimum


@pytest.mark.parametrize("seed", range(5))
def test_linear_problem_within_bounds_as_scipy_solves_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix, target = rng.normal(size=(40, 6)), rng.normal(size=40)
    lower, upper = -0.1 * np.ones(6), 0.05 * np.ones(6)
    x, rest, slope, _ = bounded_minimum(
        lambda v: matrix @ v - target, lambda _v: matrix, np.zeros(6), lower, upper, iterations=20, tolerance=1e-14
    )
    expected = optimize.lsq_linear(matrix, target, (lower, upper)).x
    np.testing.assert_allclose(x, expected, atol=1e-4)
    np.testing.assert_allclose(rest, matrix @ x - target)
    assert slope is not None


def test_curved_valley_is_followed_to_its_end() -> None:
    def residual(v: np.ndarray) -> np.ndarray:
        return np.array([10.0 * (v[1] - v[0] ** 2), 1.0 - v[0]])

    def jacobian(v: np.ndarray) -> np.ndarray:
        return np.array([[-20.0 * v[0], 10.0], [-1.0, 0.0]])

    free = np.full(2, np.inf)
    x, _, _, converged = bounded_minimum(
        residual, jacobian, np.array([-1.2, 1.0]), -free, free, iterations=60, tolerance=1e-15
    )  # fmt: skip
    np.testing.assert_allclose(x, [1.0, 1.0], atol=1e-6)
    assert converged


def test_a_kink_in_one_variable_does_not_stop_the_others() -> None:
    def residual(v: np.ndarray) -> np.ndarray:
        return np.array([v[0] - 3.0, 5.0 * np.sqrt(abs(v[1])) + 1.0])

    def jacobian(v: np.ndarray) -> np.ndarray:
        return np.array([[1.0, 0.0], [0.0, -1.0]])  # what a finite difference beside a kink may say

    free = np.full(2, np.inf)
    x, _, _, converged = bounded_minimum(
        residual, jacobian, np.zeros(2), -free, free, iterations=20, tolerance=1e-9
    )  # fmt: skip
    np.testing.assert_allclose(x, [3.0, 0.0], atol=1e-9)
    assert converged


def test_one_jacobian_serves_several_steps() -> None:
    made = []

    def residual(v: np.ndarray) -> np.ndarray:
        return np.array([np.exp(0.1 * v[0]) - 1.1, 0.5])

    def jacobian(v: np.ndarray) -> np.ndarray:
        made.append(v)
        return np.array([[0.1 * np.exp(0.1 * v[0])], [0.0]])

    free = np.full(1, np.inf)
    x, _, _, converged = bounded_minimum(residual, jacobian, np.zeros(1), -free, free, iterations=20, tolerance=1e-9)
    np.testing.assert_allclose(x, [10.0 * np.log(1.1)], atol=1e-5)
    assert converged
    assert len(made) <= 3


@pytest.mark.parametrize(("rows", "columns"), [(3, 5), (200, 22), (4194, 22), (1000, 150)])
def test_the_triangle_of_blocks_is_that_of_the_whole(rows: int, columns: int) -> None:
    rng = np.random.default_rng(0)
    slope, rest = rng.standard_normal((rows, columns)), rng.standard_normal(rows)
    triangle, target = _reduced(slope, rest)
    assert triangle.shape == (min(rows, columns), columns)
    np.testing.assert_allclose(triangle.T @ triangle, slope.T @ slope, atol=1e-10 * rows)
    np.testing.assert_allclose(triangle.T @ target, -slope.T @ rest, atol=1e-10 * rows)
