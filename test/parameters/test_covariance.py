"""A covariance is one when it is made; what a standard deviation holds beyond it is of that parameter alone."""

import numpy as np
import pytest

from flex_ident.parameters import Covariance, joined_covariance


@pytest.mark.parametrize(
    "matrix", [[[1.0, 0.0]], [[1.0, 2.0], [2.0, 1.0]], [[1.0, 0.5], [0.1, 1.0]], [[1.0, np.nan], [np.nan, 1.0]]]
)
def test_what_is_no_covariance_is_refused(matrix: list[list[float]]) -> None:
    with pytest.raises(ValueError, match="covariance"):
        Covariance(("a", "b"), np.array(matrix), np.zeros(2))


def test_stds_are_the_diagonal_and_the_rest_is_systematic() -> None:
    matrix = np.array([[4.0, 1.0, 0.5], [1.0, 1.0, 0.0], [0.5, 0.0, 9.0]])
    found = joined_covariance(["a", "b", "c"], matrix, [2.0, 1.25, np.inf])
    assert found.keys == ("a", "b")
    assert np.sqrt(np.diag(found.matrix)) == pytest.approx([2.0, 1.25])
    assert found.matrix[0, 1] == 1.0
    assert found.systematic == pytest.approx([0.0, 0.75])
    narrower = joined_covariance(["a", "b"], matrix[:2, :2], [1.0, 1.0])
    assert np.diag(narrower.matrix) == pytest.approx([1.0, 1.0])
    assert found.of(["b"])[0, 0] == pytest.approx(1.5625)
    with pytest.raises(ValueError, match="tuple"):
        found.of(["c"])
