"""Weights of residuals where friction at standstill is unknown, against the covariance written out."""

import numpy as np

from flex_ident.likelihood.reversals import Mark, ReversalWeights
from flex_ident.likelihood.whitening import Whitening

COUNT = 200
FRICTION = 3.0


def marks() -> tuple[Mark, ...]:
    bump = np.hanning(12)
    return tuple(Mark(first, bump) for first in (20, 24, 60, 150))


def written_out(rows: np.ndarray, whitening: Whitening) -> np.ndarray:
    columns = np.zeros((COUNT, 4))
    for column, mark in zip(columns.T, marks(), strict=True):
        column[mark.first : mark.first + mark.shape.size] = FRICTION * mark.shape
    return whitening(columns)[rows]


def test_weights_are_the_root_of_the_inverse_covariance() -> None:
    whitening = Whitening(np.array([1.0, -0.7, 0.2]), 0.5)
    rows = np.concatenate((np.arange(5, 100), np.arange(110, COUNT)))
    weights = ReversalWeights(marks(), FRICTION, whitening, rows)
    marked = written_out(rows, whitening)
    root = weights(np.eye(rows.size))
    np.testing.assert_allclose(root @ root, np.linalg.inv(np.eye(rows.size) + marked @ marked.T), atol=1e-6)


def test_friction_that_was_added_is_found_again() -> None:
    whitening = Whitening(np.ones(1), 0.1)
    rows = np.arange(COUNT)
    added = 1.5 * marks()[2].shape
    residual = np.random.default_rng(0).normal(0.0, 0.1, COUNT)
    residual[60:72] += added
    found = ReversalWeights(marks(), FRICTION, whitening, rows).friction(whitening(residual), COUNT)
    np.testing.assert_allclose(found[60:72], added, atol=0.2)
    np.testing.assert_allclose(found[80:140], 0.0)
