"""Turns of continuous joints, counted on where the reading wraps."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from flex_ident.excitation.joint_states import JointSample
from flex_ident.excitation.turns import Turns

TRUE = np.linspace(2.5, 11.0, 200)
"""A joint that turns by more than a turn, rad."""


def wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)


def sample(position: float | None, *others: float) -> JointSample:
    return JointSample(0.0, 0.0, position, others=others)


def positions(turns: Turns, readings: Sequence[float]) -> list[float]:
    found = [turns.unwrapped(sample(reading)).position for reading in readings]
    return [math.nan if position is None else position for position in found]


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_reading_that_wraps_goes_on(direction: float) -> None:
    own = positions(Turns((True,)), [wrapped(direction * angle) for angle in TRUE])
    np.testing.assert_allclose(np.diff(own), direction * np.diff(TRUE), atol=1e-9)


def test_the_first_reading_is_taken_as_it_is_and_after_a_restart_again() -> None:
    turns = Turns((True,))
    positions(turns, [wrapped(angle) for angle in TRUE])
    turns.restart()
    assert positions(turns, [-1.0, -1.1]) == [-1.0, -1.1]


def test_turns_are_counted_on_from_positions_that_are_known() -> None:
    turns = Turns((True,))
    turns.near((12.4,))
    assert positions(turns, [wrapped(12.6)])[0] == pytest.approx(12.6)


def test_a_joint_with_ends_jumps_where_its_reading_does() -> None:
    assert positions(Turns((False,)), [3.1, -3.1]) == [3.1, -3.1]


def test_joints_that_hold_are_counted_by_themselves() -> None:
    turns = Turns((True, False, True))
    turns.unwrapped(sample(0.0, 3.1, 3.1))
    found = turns.unwrapped(sample(0.1, -3.1, -3.1))
    assert found.position == pytest.approx(0.1)
    assert found.others == pytest.approx((-3.1, math.tau - 3.1))


def test_what_is_no_number_is_passed_on_and_forgotten() -> None:
    own = positions(Turns((True,)), [3.1, math.nan, -3.1])
    assert math.isnan(own[1])
    assert own[2] == pytest.approx(math.tau - 3.1)
    assert Turns((True,)).unwrapped(sample(None)).position is None
