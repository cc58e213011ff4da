"""What the noise is known from, on noise of a known size and colour."""

import numpy as np
import pytest
from made_up import CUTOFF, RATE, TIME, problem, reduced, white
from scipy.signal import chirp, lfilter

from flex_ident.likelihood.noise import (
    encoder_noise,
    error_at_reversals,
    is_quiet,
    link_noise,
    noise_above_band,
    noise_floor,
    noise_whitening,
    position_noise,
    torque_noise,
)
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording, Signal
from flex_ident.recording.alignment import aligned_recording

MOTION = 200.0 * chirp(TIME, 0.1, TIME[-1], 0.8 * CUTOFF, "logarithmic")
COLOURS = {
    "white": ([1.0], [1.0]),
    "falling": ([0.03], [1.0, -0.97]),
    "rising": ([1.0, -0.97], [1.0]),
}


def coloured(colour: str, seed: int = 1) -> np.ndarray:
    b, a = COLOURS[colour]
    return np.asarray(lfilter(b, a, white(seed)))


@pytest.mark.parametrize("motion", [0.0, 1.0])
@pytest.mark.parametrize("size", [0.2, 4.0])
def test_white_noise_above_the_motion_tells_that_below(motion: float, size: float) -> None:
    found = noise_above_band(problem(motion * MOTION + size * white()))
    assert found == pytest.approx(size * float(np.std(reduced(white()))), rel=0.08)


def test_falling_noise_is_said_too_small_and_rising_noise_too_large() -> None:
    ratio = {}
    for colour in COLOURS:
        noise = coloured(colour)
        found = noise_above_band(problem(MOTION + noise))
        assert found is not None
        ratio[colour] = found / float(np.std(reduced(noise)))
    assert ratio["white"] == pytest.approx(1.0, rel=0.08)
    assert ratio["falling"] < 0.6
    assert ratio["rising"] > 1.7


@pytest.mark.parametrize(("rate_hz", "known"), [(1000.0, True), (100.0, True), (80.0, False), (66.0, False)])
def test_a_rate_without_room_above_the_band_tells_nothing(rate_hz: float, known: bool) -> None:
    slow = problem(white(size=8000), rate_hz=rate_hz, decimation=1)
    assert (noise_above_band(slow) is not None) is known


def test_a_short_recording_tells_nothing() -> None:
    assert noise_above_band(problem(white(size=7000))) is None


@pytest.mark.parametrize("colour", list(COLOURS))
@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_steady_part_is_the_noise_though_errors_come_and_go(colour: str, share: float) -> None:
    noise = reduced(coloured(colour))
    time = np.arange(noise.size) * 10.0 / RATE
    error = 6.0 * float(np.std(noise)) * np.sin(2.0 * np.pi * 9.0 * time) * (np.mod(time, 10.0) < 10.0 * share)
    rows = np.ones(noise.size, bool)
    floor = noise_floor(noise + error, rows, RATE / 10.0)
    assert floor == pytest.approx(float(np.std(noise)), rel=0.2 if share == 0.0 else 0.4)
    assert share == 0.0 or floor < 0.5 * float(np.std(noise + error))


@pytest.mark.parametrize("colour", list(COLOURS))
def test_whitened_noise_has_unit_variance_and_no_memory(colour: str) -> None:
    noise = reduced(coloured(colour), 12)
    whitened = noise_whitening(noise, np.ones(noise.size, bool), RATE / 12.0, 30)(noise)[100:-100]
    assert float(np.std(whitened)) == pytest.approx(1.0, rel=0.08)
    for lag in (1, 2, 5):
        assert abs(float(np.corrcoef(whitened[lag:], whitened[:-lag])[0, 1])) < 0.12


@pytest.mark.parametrize(("moving", "quiet"), [(0.0, True), (0.3, True), (0.75, False), (1.0, False)])
def test_recording_is_quiet_where_most_of_it_holds_no_motion(moving: float, quiet: bool) -> None:
    noise = reduced(white())
    steady = noise_floor(noise, np.ones(noise.size, bool), RATE / 10.0)
    assert is_quiet(problem(white() + 300.0 * white(5) * (moving * TIME[-1] > TIME)), steady) is quiet


STEP = 2.0 * np.pi / 2**15
SPRING = Values({"Jm": 0.06, "K": 1500.0, "JL": 0.14, "FVm": 0.1, "FV": 0.08})
"""A link that rings for seconds at 16.5 Hz."""


def sprung(position: np.ndarray) -> FitProblem:
    recording = Recording("j", 500.0, position, np.zeros(position.size))
    return FitProblem(recording, sensors="motor", band_hz=40.0)


def test_what_rounding_does_through_a_spring_is_foretold() -> None:
    time = np.arange(20000) / 500.0
    smooth = 0.3 * np.sin(2.0 * np.pi * 0.3 * time) + 0.02 * chirp(time, 0.1, time[-1], 30.0)
    rounded = sprung(np.round(smooth / STEP) * STEP)
    done = rounded.prediction(SPRING).torque - sprung(smooth).prediction(SPRING).torque
    assert position_noise(rounded) == pytest.approx(STEP / np.sqrt(12.0), rel=0.1)
    (foretold,) = encoder_noise(rounded, SPRING)
    rows = rounded.usable
    assert np.std(foretold[rows]) == pytest.approx(np.std(done[rows]), rel=0.35)


@pytest.mark.parametrize("jitter_s", [0.0, 5e-6, 1e-4])
def test_rounding_is_known_at_a_low_rate_whether_stamps_jitter_or_not(jitter_s: float) -> None:
    rng, time = np.random.default_rng(2), np.arange(8000) / 250.0
    smooth = 0.3 * np.sin(2.0 * np.pi * 0.3 * time) + 0.02 * chirp(time, 0.1, time[-1], 60.0)
    stamps = time + jitter_s * np.clip(rng.standard_normal(time.size), -3.0, 3.0)
    recording = aligned_recording(
        [
            Signal("motor_position", "/j:position", "header", stamps, np.round(smooth / STEP) * STEP),
            Signal("motor_torque", "/j:effort", "header", stamps, white(1, time.size)),
        ],
        joint="j",
    )
    told = FitProblem(recording, sensors="motor", band_hz=70.0)
    assert 0.9 < position_noise(told) / (STEP / np.sqrt(12.0)) < 2.1  # of fast motion the least change is two steps


def test_a_link_encoder_is_noisier_than_its_steps_at_a_low_rate_too() -> None:
    rng, time = np.random.default_rng(3), np.arange(8000) / 250.0
    smooth = 0.3 * np.sin(2.0 * np.pi * 0.3 * time) + 0.02 * chirp(time, 0.1, time[-1], 40.0)
    link = np.round((smooth + 0.3 * STEP * rng.standard_normal(time.size)) / STEP) * STEP
    recording = Recording("j", 250.0, smooth, white(1, time.size), link_position=link)
    told = FitProblem(recording, sensors="motor+link", band_hz=50.0)
    assert told.link is not None
    assert link_noise(told) == pytest.approx(float(np.std(told.reduced(link - smooth))), rel=0.15)


def test_a_low_pass_errs_where_friction_stops_the_motor() -> None:
    time = np.arange(20000) / 500.0
    smooth = 0.05 * np.sin(2.0 * np.pi * 2.0 * time)
    stopped = np.clip(smooth, -0.045, 0.045)
    assert error_at_reversals(sprung(stopped)) > 100.0 * error_at_reversals(sprung(smooth))
    assert error_at_reversals(sprung(0.1 * time)) == pytest.approx(0.0, abs=1e-6)


def test_the_torques_noise_is_told_beside_levels_at_which_it_rests() -> None:
    time = np.arange(20000) / 500.0
    levels = 37.0 * np.sign(np.sin(2.0 * np.pi * 1.3 * time))
    smooth = 0.3 * np.sin(2.0 * np.pi * 0.3 * time)
    told = FitProblem(
        Recording("j", 500.0, smooth, levels + 0.5 * white(3, time.size)), sensors="motor", band_hz=40.0
    )  # fmt: skip
    assert torque_noise(told) == pytest.approx(0.5, rel=0.1)


def test_a_whitening_filter_knows_what_the_encoder_does() -> None:
    rows = np.ones(4000, bool)
    ringing = np.asarray(lfilter([1.0], [1.0, -1.9, 0.999], white(3)))[:4000]
    plain = noise_whitening(white(1, 4000), rows, 100.0, 24)
    knowing = noise_whitening(white(1, 4000), rows, 100.0, 24, ringing)
    assert np.std(knowing(ringing)[100:]) < 0.3 * np.std(plain(ringing)[100:])
