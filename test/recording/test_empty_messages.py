"""A second publisher's messages of zeros are left out whole; a joint that rests at zero is left alone."""

import numpy as np
import pytest

from flex_ident.recording import Floats
from flex_ident.recording.clocks import RawSignal
from flex_ident.recording.empty_messages import without_empty_messages
from flex_ident.report.sentences import sentence


def raw(name: str, values: Floats, time: Floats) -> RawSignal:
    ns = np.rint(1e9 * time).astype(np.int64)
    return RawSignal(f"/joint_states:joint.{name}", ns, ns, values)


def messages(position: Floats, effort: Floats, time: Floats) -> dict[str, RawSignal]:
    return {"motor_position": raw("position", position, time), "motor_torque": raw("effort", effort, time)}


TIME = np.arange(0.0, 10.0, 2e-3)


@pytest.mark.parametrize("middle", [0.0, 0.7])
@pytest.mark.parametrize("share", [0.01, 0.5, 1.0, 3.0])
def test_a_second_publisher_is_left_out(middle: float, share: float) -> None:
    position, effort = middle + 0.2 * np.sin(4.0 * TIME) + 1e-9, 5.0 * np.cos(4.0 * TIME) + 1e-9
    other = np.linspace(0.0003, 9.99, round(share * TIME.size))
    order = np.argsort(np.concatenate((TIME, other)), kind="stable")
    joined = [np.concatenate((v, np.zeros(other.size)))[order] for v in (position, effort)]
    found, notices = without_empty_messages(messages(*joined, np.concatenate((TIME, other))[order]))  # type: ignore
    np.testing.assert_array_equal(found["motor_position"].values, position)
    np.testing.assert_array_equal(found["motor_torque"].values, effort)
    assert f"{other.size} of {TIME.size + other.size}" in sentence(notices[0])


def test_a_joint_at_rest_at_zero_is_left_alone() -> None:
    random = np.random.default_rng(0)
    position = np.where(TIME < 3.0, 0.0, 0.3 * np.sin(5.0 * (TIME - 3.0)))
    effort = np.where(TIME < 3.0, 0.0, 2.0)
    flicker = 1e-5 * random.integers(-1, 2, TIME.size) * (TIME < 3.0)
    for at_rest in (position, position + flicker):
        found, notices = without_empty_messages(messages(at_rest, effort, TIME))  # type: ignore[arg-type]
        assert notices == []
        assert found["motor_position"].values.size == TIME.size


def test_an_effort_of_another_topic_is_left_alone() -> None:
    given = messages(np.zeros(TIME.size), np.zeros(TIME.size), TIME)
    given["motor_torque"] = raw("effort", np.zeros(10), TIME[:10])
    assert without_empty_messages(given)[1] == []  # type: ignore[arg-type]


def test_numbers_near_the_largest_there_is_are_no_positions() -> None:
    position, effort = 0.2 * np.sin(4.0 * TIME) + 0.7, 5.0 * np.cos(4.0 * TIME)
    position[25::50], effort[25::50] = 0.0, 0.0
    position[7::40] = np.where(np.arange(position[7::40].size) % 2, 1.5e308, -1.5e308)
    with np.errstate(over="raise"):
        found, notices = without_empty_messages(messages(position, effort, TIME))  # type: ignore[arg-type]
    assert found["motor_position"].values.size == TIME.size - TIME[25::50].size
    assert len(notices) == 2
