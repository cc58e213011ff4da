"""What may stand, and for how long, when nobody is there to change it; and what is commanded without feedback."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from flex_ident.excitation import Gains, JointSample, Limits
from flex_ident.excitation.command_stream import (
    LEASE_S,
    POSITION_LEASE_S,
    SHORTEST_LEASE_S,
    SHORTEST_OF_EFFORT_S,
    CommandStream,
)
from flex_ident.excitation.commands import CommandLaw, Interface

LIMITS = Limits(-0.5, 0.5, 2.0, 50.0, 0.2)
GAINS = Gains(10.0, 1.0, (30.0,), (3.0,))


def stream(interface: Interface) -> CommandStream:
    """The commands of a joint at rest at 0, held with 4 N m, beside one at 0.7 rad, held with 2 N m."""
    sample = seen(0.0)
    return CommandStream(CommandLaw(interface, GAINS, LIMITS, sample, carry=True), 0.0, 0.0, sample)


def seen(position: float, now: float = 0.0) -> JointSample:
    """A joint state."""
    return JointSample(now, now, position, 0.0, 4.0, (0.7,), (0.0,), (2.0,))


def test_a_position_may_stand_for_long_and_is_safe_itself() -> None:
    made = stream("position")
    made.follow(0.1, 0.2, 1.0, seen(0.19))
    assert made.lease_s == POSITION_LEASE_S
    assert made.safe == (0.2, (0.7,))


def test_a_speed_may_stand_the_shorter_the_nearer_a_bound_ahead_is() -> None:
    made = stream("velocity")
    assert made.lease_s == LEASE_S
    leases = []
    for position in (0.0, 0.35, 0.45, 0.499):
        made.follow(0.1, position, 1.0, seen(position))
        leases.append(made.lease_s)
        assert made.lease_s * made.command <= max(0.5 - position, SHORTEST_LEASE_S * made.command)
    assert leases[0] == LEASE_S
    assert leases == sorted(leases, reverse=True)
    assert leases[-1] < LEASE_S
    made.follow(0.1, 0.499, -1.0, seen(0.499))
    assert made.lease_s == LEASE_S
    assert made.safe == (0.0, (0.0,))


def test_what_is_safe_under_efforts_is_what_held_before() -> None:
    made = stream("effort")
    made.follow(0.1, 0.3, 0.0, seen(0.0))
    assert made.command == pytest.approx(4.0 + 10.0 * 0.3)
    assert made.safe == (4.0, (2.0,))
    assert made.lease_s == LEASE_S


@pytest.mark.parametrize("gains", [Gains(1000.0, 0.0, (30.0,), (3.0,)), Gains(1000.0, 60.0, (30.0,), (3.0,))])
def test_an_effort_accelerates_the_less_the_faster_the_joint_is_and_brakes_with_all_it_has(gains: Gains) -> None:
    law = CommandLaw("effort", gains, LIMITS, seen(0.0), carry=True)
    speeds = [-2.0, -1.0, 0.0, 0.5, 1.0, 1.5, 1.98, 2.5]
    pushes = [law.following(0.45, 1.0, replace(seen(0.0), velocity=speed)) for speed in speeds]
    assert pushes[:2] == [LIMITS.effort] * 2
    assert pushes == sorted(pushes, reverse=True)
    assert pushes[-3] > 4.0
    assert pushes[-2:] == pytest.approx([4.0, 4.0], abs=1e-9)
    assert law.following(-0.45, -1.0, replace(seen(0.0), velocity=2.5)) == -LIMITS.effort


def test_an_effort_without_limits_of_speed_and_effort_is_that_of_the_gains() -> None:
    law = CommandLaw("effort", Gains(100.0, 5.0, (30.0,), (3.0,)), Limits(), seen(0.0), carry=True)
    assert law.following(0.45, 1.0, replace(seen(0.0), velocity=3.0)) == pytest.approx(4.0 + 45.0 - 10.0)


def test_efforts_fall_with_the_lateness_of_the_reading_they_act_on() -> None:
    law = CommandLaw("effort", GAINS, LIMITS, seen(0.0), carry=True)
    off = replace(seen(0.0), others=(0.6,))
    efforts = [law.following(0.3, 0.0, off, late) for late in (0.0, 0.01, 0.05)]
    assert efforts == pytest.approx([7.0, 4.0 + 3.0 / math.e, 4.0], abs=0.03)
    held = [law.others(off, 1.0, late)[0] for late in (0.0, 0.01, 0.05)]
    assert held == pytest.approx([5.0, 2.0 + 3.0 / math.e, 2.0], abs=0.03)


def test_without_feedback_efforts_fade_and_speeds_follow_the_reference() -> None:
    made = stream("effort")
    made.follow(0.1, 2.0, 0.0, seen(0.0))
    before = made.command
    made.follow(0.15, 2.0, 0.0, None)
    assert 4.0 < made.command < before
    for k in range(100):
        made.follow(0.15 + 0.01 * k, 2.0, 0.0, None)
    assert made.command == pytest.approx(4.0, abs=0.01)
    made = stream("velocity")
    made.follow(0.1, 0.2, 0.6, seen(0.0))
    assert made.command > 0.6
    made.follow(0.2, 0.25, 0.6, None)
    assert made.command == 0.6


def test_an_effort_may_stand_the_shorter_the_faster_the_joint_goes_to_a_bound() -> None:
    made = stream("effort")
    assert made.lease_s == LEASE_S
    made.follow(0.1, 0.4, 1.0, replace(seen(0.4), velocity=1.0))
    assert made.lease_s == pytest.approx(0.05)
    assert made.seen == 0.4
    made.follow(0.1, 0.4, 1.0, replace(seen(0.4), velocity=-1.0))
    assert made.lease_s == LEASE_S
    made.follow(0.1, 0.4, 1.0, None)
    assert made.seen is None


@pytest.mark.parametrize("frequency_hz", [1.0, 5.0, 12.0])
def test_an_effort_may_stand_no_longer_than_the_joint_stays_slow_enough(frequency_hz: float) -> None:
    made = stream("effort")
    omega, speed = 2.0 * math.pi * frequency_hz, 1.5
    leases = []
    for k in range(1, 1001):
        t = 0.001 * k
        position, velocity = speed / omega * math.sin(omega * t), speed * math.cos(omega * t)
        made.follow(t, position, velocity, replace(seen(position, t), velocity=velocity))
        if k > 1:  # the first step is from rest to full speed
            leases.append(made.lease_s)
            reached = abs(velocity - speed * omega * math.sin(omega * t) * made.lease_s)
            assert reached <= LIMITS.velocity or made.lease_s == SHORTEST_OF_EFFORT_S
    assert min(leases) >= SHORTEST_OF_EFFORT_S
