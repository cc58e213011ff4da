"""Weights of residuals where friction at standstill is unknown, against the covariance written out."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flex_ident.filtering.spectral import lowpass_response
from flex_ident.likelihood import reversals
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


@pytest.mark.parametrize("last", [120, 121])
def test_friction_that_turns_over_along_a_stretch_is_within_what_the_marks_allow(
    monkeypatch: pytest.MonkeyPatch, last: int
) -> None:
    first, rate, decimation, cutoff = 100, 1000.0, 5, 20.0
    monkeypatch.setattr(reversals, "standstills", lambda _problem: [(first, last)])
    problem: Any = SimpleNamespace(
        recording=SimpleNamespace(sample_rate_hz=rate), decimation=decimation, cutoff_hz=cutoff,
        rate_hz=rate / decimation, time=np.zeros(400 // decimation),
    )  # fmt: skip
    whole, turning = reversals.friction_marks(problem)
    at = np.arange(400)
    evenly = np.clip(1.0 - 2.0 * (at - first + 0.5) / (last - first), -1.0, 1.0)
    at_once = np.sign(0.5 * (first + last) - at - 0.5)
    response = lowpass_response(np.fft.rfftfreq(800, 1.0 / rate), cutoff)
    for mark, friction in ((whole, np.where((at >= first) & (at < last), 1.0, 0.0)), (turning, at_once - evenly)):
        seen = np.fft.irfft(response * np.fft.rfft(np.pad(friction, (0, 400))), 800)[:400:decimation]
        shape = seen[mark.first : mark.first + mark.shape.size]
        assert shape @ mark.shape > 0.99 * np.linalg.norm(shape) * np.linalg.norm(mark.shape)
        assert 0.99 < np.linalg.norm(mark.shape) / np.linalg.norm(shape) < 1.7


def test_stretches_that_meet_with_their_neighbours_are_one() -> None:
    found = reversals._with_neighbours(np.array([[0, 2], [6, 7], [9, 10], [17, 20]]), 20)
    np.testing.assert_array_equal(found, [[0, 3], [5, 11], [16, 20]])
