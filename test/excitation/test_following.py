"""Whether a joint follows, told period by period: to the end, in noise, and above what its controller can do."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from servo import CHIRP as SHORT
from servo import LIMITS, Servo, commands_stay_inside, started

from flex_ident.excitation import ChirpSettings, JointSample, chirp_reference
from flex_ident.excitation.following import Following
from flex_ident.excitation.motions import FIRST_MOTION

RATE_HZ = 200.0
CHIRP = ChirpSettings(0.5, 30.0, 30.0, 0.2, profile="constant_velocity", fade_s=1.0)


def played(
    *, bandwidth_hz: float = 1e3, stops_s: float = math.inf, noise: float = 1e-5, chirp: ChirpSettings = CHIRP
) -> tuple[float, str]:
    """When something is said, s, and what, of a joint behind a first-order lag that stops at some time."""
    reference, rng = chirp_reference(chirp), np.random.default_rng(1)
    following, joint, share = Following(0.0), 0.0, 1.0 - math.exp(-2.0 * math.pi * bandwidth_hz / RATE_HZ)
    for t in np.arange(0.0, reference.total_s, 1.0 / RATE_HZ):
        position, velocity, _ = reference.at(t)
        if t < stops_s:
            joint += share * (position - joint)
        said = following.fault(t, position, velocity, joint + noise * rng.standard_normal())
        if said:
            return t, said
    return math.inf, ""


@pytest.mark.parametrize("bandwidth_hz", [1e3, 10.0, 3.0, 1.0])
@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-3])
def test_a_joint_that_follows_less_and_less_does_follow(bandwidth_hz: float, noise: float) -> None:
    assert played(bandwidth_hz=bandwidth_hz, noise=noise) == (math.inf, "")


@pytest.mark.parametrize("profile", ["constant_position", "constant_acceleration", "rich"])
def test_other_profiles_are_followed_too(profile: str) -> None:
    chirp = ChirpSettings(0.5, 30.0, 30.0, 0.05, profile=profile, fade_s=1.0)
    assert played(bandwidth_hz=10.0, chirp=chirp) == (math.inf, "")


@pytest.mark.parametrize("stops_s", [5.0, 10.0, 20.0, 25.0])
@pytest.mark.parametrize("noise", [1e-5, 1e-3])
def test_a_joint_that_stops_at_any_time_is_found_out(stops_s: float, noise: float) -> None:
    at, said = played(bandwidth_hz=20.0, stops_s=stops_s, noise=noise)
    assert stops_s < at < stops_s + 2.5
    assert "the joint has stopped following" in said


def test_one_that_never_follows_is_told_as_that() -> None:
    at, said = played(stops_s=0.0)
    assert at < 4.0
    assert "the joint does not follow: it moved" in said
    assert "is the controller active" in said


# -- the first small motion


def reading(sample: JointSample, *, noise: float, at: float | None, rng: np.random.Generator) -> JointSample:
    """A noisy sample, of a joint that stands still at a position where one is given."""
    assert sample.position is not None
    position = sample.position if at is None else at
    velocity = sample.velocity if at is None else 0.0
    return replace(sample, position=position + noise * rng.standard_normal(), velocity=velocity)


def seen(made: Servo, *, noise: float, at: float | None = None) -> Servo:
    made.sample = partial(reading, noise=noise, at=at, rng=np.random.default_rng(2))
    return made


@pytest.mark.parametrize("interface", ["position", "velocity"])
@pytest.mark.parametrize("noise", [1e-6, 1e-4, 1e-3])
@pytest.mark.parametrize("start_position", [None, 0.01])
def test_a_controller_that_does_nothing_is_found_out_before_the_chirp(
    interface: str, noise: float, start_position: float | None
) -> None:
    made = seen(started(interface=interface, start_position=start_position), noise=noise, at=0.0)
    output = made.run(5.0)
    assert output.state == "aborted"
    assert "the joint does not follow: it moved" in output.reason
    assert "is the controller active" in output.reason
    assert "exciting" not in made.states
    assert max(abs(o.position) for _, o in made.outputs) <= FIRST_MOTION + 0.01
    commands_stay_inside(made)


@pytest.mark.parametrize("interface", ["position", "velocity"])
@pytest.mark.parametrize("noise", [0.0, 1e-4, 3e-3])
def test_a_joint_that_follows_is_excited(interface: str, noise: float) -> None:
    limits = replace(LIMITS, velocity=30.0)  # noise, differentiated, is no speed
    made = seen(started(interface=interface, limits=limits), noise=noise)
    made.run(3.0)
    assert made.states[:3] == ["idle", "moving_to_start", "exciting"]
    first = [o.position for _, o in made.outputs if o.state == "moving_to_start"]
    assert max(first) == pytest.approx(FIRST_MOTION, rel=1e-3)
    assert min(first) >= 0.0


def test_the_first_motion_is_no_larger_than_the_chirp_and_stays_inside_the_limits() -> None:
    small = replace(SHORT, amplitude=0.01)
    made = started(chirp=small)
    made.run(1.5)
    bounds = chirp_reference(small).bounds
    reached = [o.position for _, o in made.outputs if o.state == "moving_to_start"]
    assert 0.0 < max(reached) <= 0.5 * bounds.high + 1e-9 or 0.0 > min(reached) >= 0.5 * bounds.low - 1e-9


def test_a_way_to_the_start_shows_by_itself_that_the_joint_follows() -> None:
    made = started(start_position=0.2)
    made.run(3.0)
    positions = [o.position for _, o in made.outputs if o.state == "moving_to_start"]
    assert all(b >= a for a, b in pairwise(positions))


def test_effort_commands_make_no_first_motion() -> None:
    made = started(interface="effort")
    made.run(0.9)
    assert {o.position for _, o in made.outputs} == {0.0}
