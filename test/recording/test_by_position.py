"""A joint that is moved by hand, and one that its motor moves: simulated here, by a plant of its own."""

from __future__ import annotations

import numpy as np
import pytest

from flex_ident.errors import ExcitationError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.recording import Recording
from flex_ident.recording.by_position import left_by_position

RATE_HZ = 200.0
TIME = np.arange(0.0, 20.0, 1.0 / RATE_HZ)
HAND = 0.5 * np.sin(1.1 * TIME) + 0.3 * np.sin(2.9 * TIME + 1.0)
"""Position, rad, of a joint that somebody leads about."""


def weight(position: np.ndarray) -> np.ndarray:
    return 9.81 * (1.0 * np.cos(position) + 4.0 * np.sin(position))


def driven(position: np.ndarray, friction: float) -> np.ndarray:
    """The effort of a motor that moves 2.2 kg m^2 along the positions, N m."""
    speed = np.gradient(position, 1.0 / RATE_HZ)
    return 2.2 * np.gradient(speed, 1.0 / RATE_HZ) + friction * np.sign(speed) + weight(position)


def recorded(position: np.ndarray, effort: np.ndarray) -> Recording:
    return Recording("joint_2", RATE_HZ, position, effort)


@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_an_effort_of_gravity_alone_is_that_of_a_joint_moved_by_hand(noise: float) -> None:
    effort = 1.03 * weight(HAND) + noise * np.random.default_rng(3).standard_normal(TIME.size)
    left = left_by_position(HAND, effort, RATE_HZ)
    assert left is not None
    assert left < 0.03
    for options in (IdentifyOptions(rigid=True), IdentifyOptions()):
        with pytest.raises(ExcitationError, match="follows its position alone"):
            identify(recorded(HAND, effort), options)


@pytest.mark.parametrize("friction", [0.5, 7.5])
def test_an_effort_that_knows_which_way_the_joint_moves_is_a_motors(friction: float) -> None:
    assert left_by_position(HAND, driven(HAND, friction), RATE_HZ) is None


def test_little_motion_tells_nothing() -> None:
    assert left_by_position(HAND[:400], weight(HAND[:400]), RATE_HZ) is None
    assert left_by_position(np.zeros(TIME.size), np.ones(TIME.size), RATE_HZ) is None


def test_short_steps_between_rests_are_refused_in_one_line() -> None:
    phase = np.clip((TIME % 1.0) / 0.25, 0.0, 1.0)
    steps = 0.2 * (np.floor(TIME) % 5 + phase**3 * (10.0 - 15.0 * phase + 6.0 * phase**2))
    with pytest.raises(ExcitationError, match="never moves for long enough"):
        identify(recorded(steps, driven(steps, 7.5)), IdentifyOptions(rigid=True))
