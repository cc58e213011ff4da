"""Whether a joint follows, told period by period: to the end, in noise, and above what its controller can do."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flex_ident.excitation import ChirpSettings, chirp_reference
from flex_ident.excitation.following import Following

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
