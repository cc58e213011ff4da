"""One tone, one speed, or a motion that tells things apart."""

import numpy as np
import pytest
from scipy import signal

from flex_ident.estimation.identification import identify
from flex_ident.estimation.motion_told import motion_notice, with_motion_told
from flex_ident.filtering.motion_kind import constant_speed, single_tone_hz
from flex_ident.recording import Floats, Recording
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

RATE = 500.0
TIME = np.arange(0.0, 20.0, 1.0 / RATE)
CHAIN = MeasurementChain.with_bits(19, 20)


def _tone(frequency_hz: float, **changed: float) -> Recording:
    experiment = Experiment(
        duration_s=20.0, sample_rate_hz=RATE, start_frequency_hz=frequency_hz, end_frequency_hz=1.0001 * frequency_hz,
        **changed,  # type: ignore[arg-type]
    )  # fmt: skip
    return virtual_recording(COBOT_JOINT, experiment, CHAIN, seed=3, link=False)


@pytest.mark.parametrize("frequency_hz", [0.3, 1.0, 5.0, 15.0])
def test_a_tone_is_told_with_its_frequency_whatever_friction_adds_to_its_torque(frequency_hz: float) -> None:
    notice = motion_notice(_tone(frequency_hz))
    assert notice is not None
    assert notice.code == "single_tone"
    assert notice.numbers["frequency_hz"] == pytest.approx(frequency_hz, rel=0.05)


@pytest.mark.parametrize("profile", ["falling", "rich"])
@pytest.mark.parametrize("sweep", ["linear", "logarithmic"])
def test_a_sweep_is_no_tone(profile: str, sweep: str) -> None:
    experiment = Experiment(duration_s=20.0, sample_rate_hz=RATE, profile=profile, sweep=sweep)  # type: ignore[arg-type]
    assert motion_notice(virtual_recording(COBOT_JOINT, experiment, CHAIN, seed=3, link=False)) is None


def test_a_sweep_through_a_sharp_resonance_is_no_tone_by_its_torque() -> None:
    torque = signal.chirp(TIME, 0.1, 20.0, 30.0)
    numerator, denominator = signal.iirpeak(8.0, 60.0, fs=RATE)
    velocity: Floats = signal.lfilter(numerator, denominator, torque)
    position = np.cumsum(velocity) / RATE
    assert single_tone_hz(position, velocity, RATE) == pytest.approx(8.0, rel=0.05)  # else it shows nothing
    assert single_tone_hz(position, torque, RATE) is None


def test_to_and_fro_at_one_speed_is_told() -> None:
    there_and_back = 0.4 * signal.sawtooth(2.0 * np.pi * 0.2 * TIME, 0.5)
    assert constant_speed(there_and_back, RATE) == pytest.approx(0.32, rel=0.05)
    assert constant_speed(np.sin(2.0 * np.pi * TIME), RATE) is None
    two = np.where(TIME < 10.0, there_and_back, 3.0 * there_and_back)
    assert constant_speed(two, RATE) is None


def test_nothing_is_told_of_a_joint_that_stands() -> None:
    assert single_tone_hz(np.zeros(1000), np.zeros(1000), RATE) is None
    assert constant_speed(np.zeros(1000), RATE) is None
    assert constant_speed(np.zeros(10), RATE) is None


def test_it_is_told_once() -> None:
    once = with_motion_told(_tone(1.0))
    assert [n.code for n in once.notices] == ["single_tone"]
    assert with_motion_told(once) is once


@pytest.mark.slow
def test_no_number_of_a_tone_is_trusted_and_the_advice_is_to_sweep() -> None:
    """At 1 Hz inertia and gravity are alike: J came out 4 % high and 11 standard deviations off, trusted."""
    result = identify(_tone(1.0))
    assert result.verdict == "doubtful"
    assert "single_tone" in [n.code for n in result.notices]
