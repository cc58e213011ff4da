"""Signals as they come from robots, against a truth that is known at every instant."""

import tracemalloc

import numpy as np
import pytest

from flex_ident.errors import ExcitationError, SignalError
from flex_ident.recording import Floats, Recording, Signal
from flex_ident.recording.alignment import aligned_recording
from flex_ident.recording.recording import Role
from flex_ident.report.sentences import sentence

TONES = ((0.3, 0.7, 0.0), (0.1, 6.3, 1.0), (0.02, 17.0, 2.0), (0.01, 29.0, 3.0))
"""Amplitude, Hz, phase: nothing above 30 Hz, as in a chirp."""


def truth(time: Floats) -> Floats:
    return np.sum([a * np.sin(2 * np.pi * f * time + p) for a, f, p in TONES], axis=0)


def rate_of_truth(time: Floats) -> Floats:
    return np.sum([2 * np.pi * f * a * np.cos(2 * np.pi * f * time + p) for a, f, p in TONES], axis=0)


def sampled(
    role: Role,
    rate_hz: float,
    *,
    seconds: float = 20.0,
    skew: float = 0.0,
    jitter: float = 0.0,
    lost: float = 0.0,
    gap: tuple[float, float] | None = None,
    late: float = 0.0,
    seed: int = 0,
    scale: float = 1.0,
) -> Signal:
    """The truth at `rate_hz`, taken `skew` s late; `jitter` in periods; `late` s of mean delay to its reception."""
    random = np.random.default_rng((seed, len(role)))
    n = int(seconds * rate_hz)
    time = skew + (np.arange(n) + jitter * random.standard_normal(n).clip(-3, 3)) / rate_hz
    values = scale * truth(time)
    kept = random.random(n) >= lost
    kept[[0, -1]] = True
    if gap is not None:
        kept &= (time < gap[0]) | (time > gap[1])
    if late:
        time = np.maximum.accumulate(time + 1e-3 + random.exponential(late, n)) + 1e-9 * np.arange(n)
    return Signal(role, f"/{role}", "receive" if late else "header", time[kept], values[kept])


def delay(found: Floats, clock: Floats) -> float:
    """By how much `found` lies behind the truth, s, in the sense of least squares."""
    slope = rate_of_truth(clock)
    return float((truth(clock) - found) @ slope / (slope @ slope))


def recorded(*signals: Signal) -> tuple[Recording, Floats]:
    """The recording, and its clock on the truth's axis."""
    recording = aligned_recording(list(signals), joint="j")
    return recording, recording.time + recording.start_time_s


@pytest.mark.parametrize("rate_hz", [250.0, 350.87, 1000.0])
@pytest.mark.parametrize("others_hz", [200.0, 350.87, 500.0, 4000.0])
def test_rates_and_skews(rate_hz: float, others_hz: float) -> None:
    recording, clock = recorded(
        sampled("motor_position", rate_hz),
        sampled("motor_torque", others_hz, skew=0.37 / others_hz),
        sampled("link_position", others_hz, skew=-0.21 / others_hz),
    )
    assert recording.sample_rate_hz == pytest.approx(rate_hz, rel=1e-9)
    assert recording.link_position is not None
    np.testing.assert_allclose(recording.motor_position, truth(clock), atol=1e-9)
    inner = slice(50, -50)
    slowest = min(rate_hz, others_hz)
    for values in (recording.motor_torque, recording.link_position):
        assert abs(delay(values[inner], clock[inner])) < 0.005 / slowest
        assert np.std(values[inner] - truth(clock)[inner]) < 0.002 * np.std(truth(clock))


@pytest.mark.parametrize("seed", range(3))
def test_jitter_and_lost_samples(seed: int) -> None:
    """A twentieth of a period of jitter, and two samples in a thousand lost: what a robot's controller leaves."""
    rate = 350.87
    motor = sampled("motor_position", rate, jitter=0.05, lost=0.002, seed=seed)
    torque = Signal("motor_torque", "/torque", "header", motor.time, truth(motor.time))
    recording, clock = recorded(motor, torque)
    found = recording.sampling[0]
    assert found.rate_hz == pytest.approx(rate, rel=2e-5)
    assert found.jitter_percent == pytest.approx(5.0 * 2**0.5, rel=0.1)
    count = int(20 * rate)
    assert found.lost_percent == pytest.approx(100.0 * (count - motor.time.size) / count, abs=1e-9)
    inner = slice(50, -50)
    assert abs(delay(recording.motor_position[inner], clock[inner])) < 1e-3 / rate
    assert np.std((recording.motor_position - truth(clock))[inner]) < 5e-4 * np.std(truth(clock))
    assert recording.measured is not None
    assert recording.measured.all()


def test_even_samples_are_taken_as_they_stand() -> None:
    motor, torque = sampled("motor_position", 500.0), sampled("motor_torque", 500.0)
    recording, _ = recorded(motor, torque)
    np.testing.assert_array_equal(recording.motor_position, motor.values)
    np.testing.assert_array_equal(recording.motor_torque, torque.values)


def test_gap_is_bridged_and_left_out() -> None:
    recording, clock = recorded(
        sampled("motor_position", 500.0), sampled("motor_torque", 500.0, gap=(7.0, 7.4), skew=1e-4)
    )
    assert recording.measured is not None
    inside = (clock > 7.002) & (clock < 7.398)
    assert not recording.measured[inside].any()
    assert recording.measured[~((clock > 6.998) & (clock < 7.402))].all()
    good = recording.measured & (np.abs(clock - 7.2) > 0.22)
    np.testing.assert_allclose(recording.motor_torque[good][10:-10], truth(clock)[good][10:-10], atol=1e-3)
    assert np.abs(recording.motor_torque).max() < 1.0
    assert [n.code for n in recording.notices] == ["gaps"]
    assert "2.01 % of the recording" in sentence(recording.notices[0])
    assert recording.sampling[1].longest_gap_s == pytest.approx(0.402, abs=0.003)


def test_times_of_reception_are_made_even() -> None:
    """Messages that arrive half a period late on average, each otherwise, were taken evenly."""
    rate = 500.0
    motor = sampled("motor_position", rate, late=0.5 / rate, lost=0.002)
    torque = Signal("motor_torque", "/torque", "receive", motor.time, motor.values)
    recording, clock = recorded(motor, torque)
    assert recording.sample_rate_hz == pytest.approx(rate, rel=1e-4)
    lag = delay(recording.motor_position, clock)
    assert 1e-3 < lag < 1e-3 + 1.0 / rate  # the latency itself cannot be known
    shifted = truth(clock - lag)
    inner = slice(100, -100)
    assert np.std((recording.motor_position - shifted)[inner]) < 5e-3 * np.std(shifted)


def test_recording_that_pauses_is_its_longest_part() -> None:
    first, second = (sampled(role, 500.0, seconds=4.0) for role in ("motor_position", "motor_torque"))
    later = [
        Signal(s.role, s.source, "header", np.concatenate((s.time[:500], s.time[500:] + 1.7e6)), s.values)
        for s in (first, second)
    ]
    recording, _ = recorded(*later)
    assert recording.time.size == 1500
    assert [n.code for n in recording.notices] == ["paused"]
    assert "2.998 s" in sentence(recording.notices[0])


def test_signals_that_do_not_overlap_are_refused() -> None:
    with pytest.raises(ExcitationError, match=r"0 samples \(0 s at 500 Hz\) in which all signals overlap"):
        recorded(sampled("motor_position", 500.0, seconds=2.0), sampled("motor_torque", 500.0, skew=5.0))


def test_hour_long_recording_with_jitter_stays_on_time() -> None:
    """1.2 million samples; the clock drifts by less than a thousandth of a sample over all of them."""
    rate = 1000.0
    motor = sampled("motor_position", rate, seconds=1200.0, jitter=0.02, lost=0.001)
    torque = Signal("motor_torque", "/torque", "header", motor.time, motor.values)
    recording, clock = recorded(motor, torque)
    for part in (slice(100, 60_000), slice(-60_000, -100)):
        assert abs(delay(recording.motor_position[part], clock[part])) < 1e-3 / rate


@pytest.mark.parametrize("period", [1e-9, 1e-7, 5e-6])
@pytest.mark.parametrize("role", ["motor_position", "motor_torque"])
def test_times_that_no_samples_can_have_are_refused(period: float, role: Role) -> None:
    signals = [sampled("motor_position", 500.0), sampled("motor_torque", 500.0)]
    close = [
        Signal(s.role, s.source, "header", period * np.arange(s.time.size), s.values) if s.role == role else s
        for s in signals
    ]
    with pytest.raises(SignalError, match=r"lie [0-9.e+]+ ns apart .*e\+0"):
        recorded(*close)


def test_bursts_far_apart_do_not_ask_for_memory_between_them() -> None:
    time = np.concatenate((2e-5 * np.arange(2000), 3.9 + 2e-5 * np.arange(2000)))
    torque = Signal("motor_torque", "/torque", "header", time, truth(time))
    tracemalloc.start()
    try:
        recorded(sampled("motor_position", 500.0, seconds=4.0), torque)
        assert tracemalloc.get_traced_memory()[1] < 5e6
    finally:
        tracemalloc.stop()
