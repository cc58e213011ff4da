"""Positions that wrap are made continuous, an encoder that counts the other way round is refused."""

import numpy as np
import pytest

from flex_ident.bags.encoders import refuse_opposite, unwrapped
from flex_ident.errors import SignalError
from flex_ident.recording import Floats, Signal

TIME = np.arange(0.0, 10.0, 0.002)
MOTION = 3.0 + 0.5 * np.sin(2.0 * np.pi * 0.5 * TIME)
"""Crosses half a turn."""


def signals(motor: Floats, link: Floats | None = None) -> list[Signal]:
    found = [Signal("motor_position", "motor", "header", TIME, motor)]
    return found if link is None else [*found, Signal("link_position", "link", "header", TIME, link)]


def wrapped(angle: Floats) -> Floats:
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def test_positions_that_wrap_are_made_continuous_and_it_is_said() -> None:
    [motor, link], notices = unwrapped(signals(wrapped(MOTION), wrapped(MOTION - 1e-3)), {})
    assert np.allclose(motor.values - motor.values[0], MOTION - MOTION[0])
    assert np.allclose(link.values - link.values[0], MOTION - MOTION[0])
    assert [n.code for n in notices] == ["position_unwrapped"] * 2


def test_a_motor_that_wraps_on_its_own_side_of_the_gear() -> None:
    [motor], notices = unwrapped(signals(wrapped(100.0 * MOTION[: TIME.size]) / 100.0), {"motor_position": 0.01})
    assert np.allclose(np.diff(motor.values), np.diff(MOTION))
    assert len(notices) == 1


@pytest.mark.parametrize("motion", [MOTION, 20.0 * MOTION, np.round(MOTION)])
def test_what_does_not_wrap_is_left_alone(motion: Floats) -> None:
    [motor], notices = unwrapped(signals(motion), {})
    assert motor.values is motion or np.array_equal(motor.values, motion)
    assert notices == []


def test_a_link_that_counts_the_other_way_round_is_refused() -> None:
    refuse_opposite(signals(MOTION, MOTION + 0.1))
    with pytest.raises(SignalError, match="link moves opposite to motor"):
        refuse_opposite(signals(MOTION, 0.1 - MOTION))
