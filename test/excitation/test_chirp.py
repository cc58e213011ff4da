"""The reference: its velocity is its derivative, it keeps to its bounds, and time is all it depends on."""

import numpy as np
import pytest

from flex_ident.errors import ConfigurationError
from flex_ident.excitation import ChirpSettings, chirp_reference
from flex_ident.excitation.chirp import PROFILES, SWEEPS


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("sweep", SWEEPS)
def test_velocity_is_the_derivative_and_bounds_hold(profile: str, sweep: str) -> None:
    reference = chirp_reference(ChirpSettings(0.5, 12.0, 6.0, 0.2, profile=profile, sweep=sweep, fade_s=0.5, repeats=2))
    t = np.arange(0.0, 12.0, 2e-4)
    q, v = np.array([reference.at(x) for x in t]).T
    error = np.abs(np.gradient(q, t) - v)
    # A corner of the profile, where the acceleration jumps, is all that finite differences may miss.
    assert np.mean(error > 2e-3 * np.abs(v).max()) < 1e-3
    low, high, speed, _ = reference.bounds()
    assert low <= q.min()
    assert q.max() <= high
    assert np.abs(v).max() <= speed


def test_it_starts_and_ends_at_rest() -> None:
    reference = chirp_reference(ChirpSettings(duration_s=10.0))
    for t in (0.0, 10.0 - 1e-9, 10.0, 11.0, -1.0):
        position, velocity = reference.at(t)
        assert abs(position) < 1e-6
        assert abs(velocity) < 1e-5


def test_constant_velocity_means_constant_velocity() -> None:
    reference = chirp_reference(ChirpSettings(0.5, 20.0, 20.0, 0.1, profile="constant_velocity", fade_s=0.0))
    t = np.arange(0.0, 20.0, 1e-3)
    v = np.abs([reference.at(x)[1] for x in t])
    first, last = v[:5000].max(), v[-5000:].max()
    assert last == pytest.approx(first, rel=0.02)
    assert first == pytest.approx(0.1 * 2 * np.pi * 0.5, rel=0.02)


@pytest.mark.parametrize(
    "wrong", [{"profile": "steady"}, {"sweep": "up"}, {"amplitude": 0.0}, {"repeats": 0}, {"fade_s": 100.0}]
)
def test_what_makes_no_sense_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(wrong))):
        ChirpSettings(**wrong)  # type: ignore[arg-type]
