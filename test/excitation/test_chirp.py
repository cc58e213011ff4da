"""The reference: exact derivatives, bounds that hold and are tight, and time is all it depends on."""

import numpy as np
import pytest

from flex_ident.errors import ConfigurationError
from flex_ident.excitation import ChirpSettings, chirp_reference
from flex_ident.excitation.chirp import PROFILES, RICH_PARTS, SWEEPS

FREQUENCIES = [(0.5, 12.0), (12.0, 0.5), (3.0, 3.0)]


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("sweep", SWEEPS)
@pytest.mark.parametrize(("start", "end"), FREQUENCIES)
def test_derivatives_are_exact_and_bounds_hold(profile: str, sweep: str, start: float, end: float) -> None:
    settings = ChirpSettings(start, end, 3.0, 0.2, profile=profile, sweep=sweep, fade_s=0.5, repeats=2)
    reference = chirp_reference(settings)
    t = np.arange(0.0, reference.total_s, 2e-3)
    q, v, a = np.array([reference.at(x) for x in t]).T
    step = 1e-6
    before, after = (np.array([reference.at(x + d) for x in t[1:-1]]).T for d in (-step, step))
    # At the ends of fades, and where the amplitude of the rich profile bends, the next derivative jumps.
    for derivative, values in ((v, (before[0], after[0])), (a, (before[1], after[1]))):
        error = np.abs((values[1] - values[0]) / (2 * step) - derivative[1:-1])
        assert np.sum(error > 1e-5 * np.abs(derivative).max()) <= 12
    bounds = reference.bounds
    for bound, extreme in zip(bounds, (q.min(), q.max(), np.abs(v).max(), np.abs(a).max()), strict=True):
        assert 0.9 * abs(bound) <= abs(extreme) <= abs(bound)


def test_it_starts_and_ends_at_rest() -> None:
    for profile in PROFILES:
        reference = chirp_reference(ChirpSettings(duration_s=10.0, profile=profile))
        for t in (-1.0, 0.0, reference.total_s - 1e-9, reference.total_s, 1e9):
            position, velocity, _ = reference.at(t)
            assert abs(position) < 1e-6
            assert abs(velocity) < 1e-5


@pytest.mark.parametrize(
    ("profile", "power"), [("constant_position", 0), ("constant_velocity", 1), ("constant_acceleration", 2)]
)
def test_a_profile_holds_what_its_name_says(profile: str, power: int) -> None:
    reference = chirp_reference(ChirpSettings(0.5, 20.0, 20.0, 0.1, profile=profile, fade_s=0.0))
    values = np.abs([reference.at(x)[power] for x in np.arange(0.0, 20.0, 2e-3)])
    for third in np.split(values[1000:10000], 3):
        assert third.max() == pytest.approx(0.1 * (2.0 * np.pi * 0.5) ** power, rel=0.03)


def test_a_logarithmic_sweep_spends_the_same_time_in_each_octave() -> None:
    reference = chirp_reference(ChirpSettings(1.0, 16.0, 8.0, 0.1, profile="constant_position", fade_s=0.0))
    q = np.array([reference.at(x)[0] for x in np.arange(0.0, 8.0, 1e-3)])
    crossings = np.diff(np.flatnonzero(np.diff(np.sign(q)) != 0)) * 1e-3
    assert 0.5 / crossings[0] == pytest.approx(1.1, rel=0.15)
    assert 0.5 / crossings[-1] == pytest.approx(16.0, rel=0.05)
    octave = [np.sum(np.diff(np.sign(q[k : k + 2000])) != 0) for k in (0, 2000, 4000, 6000)]
    assert np.allclose(np.divide(octave[1:], octave[:-1]), 2.0, atol=0.35)


def test_rich_is_three_parts_and_repeats() -> None:
    reference = chirp_reference(ChirpSettings(0.5, 20.0, 30.0, 0.3, profile="rich"))
    assert reference.total_s == 60.0
    t = np.arange(0.0, 30.0, 5e-2)
    once, again = ([reference.at(x + shift)[0] for x in t] for shift in (0.0, 30.0))
    assert np.allclose(once, again, atol=1e-9)
    edges = np.cumsum([0.0, *(share * 30.0 for share, _ in RICH_PARTS)])
    for low, high, (_, size) in zip(edges, edges[1:], RICH_PARTS, strict=False):
        assert np.abs([reference.at(x)[0] for x in np.arange(low, high, 5e-3)]).max() == pytest.approx(
            0.3 * size, rel=0.1
        )


@pytest.mark.slow
def test_the_longest_chirp_has_its_bounds() -> None:
    reference = chirp_reference(ChirpSettings(0.05, 200.0, 3600.0, 0.1, sweep="linear", profile="constant_position"))
    assert reference.bounds.speed == pytest.approx(0.1 * 2.0 * np.pi * 200.0, rel=0.01)


@pytest.mark.parametrize(
    "wrong",
    [{"profile": "steady"}, {"sweep": "up"}, {"amplitude": 0.0}, {"amplitude": float("nan")}, {"repeats": 0},
     {"fade_s": 100.0}, {"duration_s": float("inf")}, {"start_frequency_hz": -1.0}],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(wrong))):
        ChirpSettings(**wrong)  # type: ignore[arg-type]
