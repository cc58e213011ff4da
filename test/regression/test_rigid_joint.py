"""A rigid joint with and without gravity, and what the fit says of a torque with the wrong sign."""

import numpy as np
import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import Identification
from flex_ident.recording import Recording
from flex_ident.regression import identify_linear
from flex_ident.report.sentences import sentence

RATE = 500.0
TRUTH = {"J": 2.0, "FV": 3.0, "FS": 1.0, "MX": 3.0, "MY": 1.0}


def recorded(
    *, gravity: bool, centre: float = 0.0, amplitude: float = 0.3, scale: float = 1.0, seed: int = 0, drift: float = 0.0
) -> Recording:
    """A chirp of 0.2 to 8.2 Hz in 20 s; `drift`, N m, is noise that is correlated over a tenth of a second."""
    random = np.random.default_rng(seed)
    t = np.arange(0.0, 20.0, 1.0 / RATE)
    phase, omega = 2 * np.pi * (0.2 * t + 0.2 * t**2), 2 * np.pi * (0.2 + 0.4 * t)
    q, v = centre + amplitude * np.sin(phase), amplitude * omega * np.cos(phase)
    a = amplitude * (2 * np.pi * 0.4 * np.cos(phase) - omega**2 * np.sin(phase))
    slow = np.convolve(random.normal(0.0, drift, t.size), np.ones(50) / 50**0.5, "same")
    torque = TRUTH["J"] * a + TRUTH["FV"] * v + TRUTH["FS"] * np.sign(v) + random.normal(0.0, 0.3, t.size) + slow
    if gravity:
        torque = torque + 9.81 * (TRUTH["MX"] * np.cos(q) + TRUTH["MY"] * np.sin(q))
    return Recording("j", RATE, q + random.normal(0.0, 1e-5, t.size), scale * torque)


def rigid(recording: Recording) -> Identification:
    return identify_linear(recording, sensors="motor", rigid=True)


@pytest.mark.parametrize("centre", [0.0, 1.0, -2.0])
@pytest.mark.parametrize("seed", range(3))
def test_gravity_is_found(centre: float, seed: int) -> None:
    result = rigid(recorded(gravity=True, centre=centre, seed=seed))
    assert result.verdict == "trusted"
    for key, truth in TRUTH.items():
        p = result.parameter(key)
        assert p.identifiable, key
        assert abs(p.value - truth) < 4.0 * p.std, key
    assert result.model.value("MX") == result.parameter("MX").value


@pytest.mark.parametrize("drift", [0.0, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_gravity_that_is_not_there_is_not_found(drift: float, seed: int) -> None:
    result = rigid(recorded(gravity=False, drift=drift, seed=seed))
    assert [p.key for p in result.parameters] == ["J", "FV", "FS", "offset"]
    assert result.parameter("J").value == pytest.approx(2.0, rel=0.01)


def test_gravity_over_a_short_travel_is_not_told_from_an_offset_but_does_not_bias_the_inertia() -> None:
    result = rigid(recorded(gravity=True, centre=1.0, amplitude=0.02))
    assert not result.parameter("MY").identifiable
    assert not result.parameter("offset").identifiable
    assert [n for n in result.notices if n.code == "not_identifiable" and "another start position" in sentence(n)]
    j = result.parameter("J")
    assert abs(j.value - 2.0) < 4.0 * j.std


@pytest.mark.slow
def test_a_joint_that_slides_has_no_gravity_columns() -> None:
    recording = recorded(gravity=True)
    result = identify(recording, IdentifyOptions(rigid=True), prismatic=True)
    assert [p.key for p in result.parameters] == ["J", "FV", "FS", "offset"]


def test_reversed_effort_is_named() -> None:
    result = rigid(recorded(gravity=False, scale=-1.0))
    assert result.verdict == "rejected"
    assert result.notices[0].code == "effort_reversed"
    assert "--effort-scale -1" in sentence(result.notices[0])


def test_warnings_state_two_sigma_as_the_table_does() -> None:
    result = rigid(recorded(gravity=True, centre=1.0, amplitude=0.02))
    p = result.parameter("MY")
    assert any(f"± {2.0 * p.std:.2g} kg m, 2σ" in sentence(n) for n in result.notices)
