"""Stamps of coarse clocks and of clocks that were set are made even; clean ones are left alone."""

import dataclasses

import numpy as np
import pytest

from flex_ident.recording import Signal
from flex_ident.recording.clocks import RawSignal, signals_of
from flex_ident.recording.recording import Floats
from flex_ident.report.sentences import sentence

EPOCH = 1_700_000_000_000_000_000
SAMPLES = 4000


def raw(stamps_s: Floats, received_s: Floats) -> RawSignal:
    values = np.sin(7.0 * np.arange(stamps_s.size) / 250.0)
    return RawSignal(
        "/t:a.position", EPOCH + np.rint(received_s * 1e9).astype(np.int64),
        EPOCH + np.rint(stamps_s * 1e9).astype(np.int64), values,
    )  # fmt: skip


def read(stamps_s: Floats, received_s: Floats) -> tuple[Signal, list[str]]:
    signals, notices, _ = signals_of({"motor_position": raw(stamps_s, received_s)}, joint="a")
    return signals[0], [f"{n.code}: {sentence(n)}" for n in notices]


def arrivals(time: Floats, random: np.random.Generator, jitter_s: float) -> Floats:
    return np.sort(time + 0.0004 + random.exponential(jitter_s, time.size))


@pytest.mark.parametrize("rate", [100.0, 250.0, 400.0, 1000.0, 4000.0])
@pytest.mark.parametrize("jitter_s", [1e-5, 3e-4, 2e-3])
@pytest.mark.parametrize("lost", [0.0, 0.02])
def test_clean_stamps_are_left_alone(rate: float, jitter_s: float, lost: float) -> None:
    random = np.random.default_rng(3)
    time = np.arange(SAMPLES) / rate
    time = time[random.random(SAMPLES) >= lost]
    jittered = time + np.clip(random.normal(0.0, 0.05 / rate, time.size), -0.3 / rate, 0.3 / rate)
    for stamps in (time, jittered):
        signal, said = read(stamps, arrivals(time, random, jitter_s))
        assert said == []
        np.testing.assert_allclose(signal.time, stamps - stamps[0], atol=1e-6)


def test_a_recorder_that_stands_still_for_a_while_is_no_clock_that_was_set() -> None:
    random = np.random.default_rng(4)
    time = np.arange(SAMPLES) / 500.0
    received = arrivals(time, random, 2e-4)
    received[1000:1100] = np.maximum(received[1000:1100], received[1099])
    received[2000:] += 0.05  # a queue that stays full
    signal, said = read(time, received)
    assert said == []
    np.testing.assert_allclose(signal.time, time, atol=1e-9)


@pytest.mark.parametrize("rate", [250.0, 400.0, 800.0])
@pytest.mark.parametrize("tick", [0.0005, 0.001, 0.004 / 3])
@pytest.mark.parametrize("lost", [0.0, 0.01])
def test_coarse_ticks_are_evened(rate: float, tick: float, lost: float) -> None:
    random = np.random.default_rng(5)
    if lost and tick * rate > 0.5:
        pytest.skip("steps of ticks as long as the period do not tell a lost message")
    tick = round(tick * 1e9) * 1e-9
    time = np.arange(SAMPLES) / (rate * 1.0003)
    time = time[random.random(SAMPLES) >= lost]
    stamps = np.floor(time / tick + 1e-6) * tick
    signal, said = read(stamps, arrivals(time, random, 1e-4))
    assert [s.partition(":")[0] for s in said] == ["coarse_stamps"]
    assert f"ticks of {tick * 1e3:.4g} ms" in said[0]
    off = signal.time - (time - time[0])
    assert np.std(off) < 0.2 * np.std(stamps - time)


@pytest.mark.parametrize("noise", [0.0, 2e-5])
@pytest.mark.parametrize(("tick", "between"), [(0.002, (5, 5, 6)), (0.004, (3, 4)), (0.001, (2, 3, 3, 4))])
def test_samples_of_a_controller_that_was_asked_unevenly(tick: float, between: tuple[int, ...], noise: float) -> None:
    random = np.random.default_rng(7)
    time = tick * np.cumsum(random.choice(between, SAMPLES))
    own = raw(time, arrivals(time, random, 1e-4))
    even = np.linspace(0.0, time[-1], SAMPLES)
    for values, kept in ((np.sin(3.0 * time), True), (np.sin(3.0 * even), False)):
        noisy = dataclasses.replace(own, values=values + noise * random.standard_normal(SAMPLES))
        torque = dataclasses.replace(own, values=random.standard_normal(SAMPLES))
        signals, notices, _ = signals_of({"motor_position": noisy, "motor_torque": torque}, joint="a")
        assert bool(notices) is not kept
        for signal in signals:
            assert np.allclose(signal.time, time - time[0], atol=1e-9) is kept


@pytest.mark.parametrize("rate", [100.0, 500.0, 1000.0])
@pytest.mark.parametrize("step_s", [-3600.0, -0.2, -0.03, 0.03, 0.25, 3600.0])
def test_a_clock_that_was_set_is_taken_back(rate: float, step_s: float) -> None:
    random = np.random.default_rng(6)
    time = np.arange(SAMPLES) / rate
    stamps = time + np.where(time > 0.4 * time[-1], step_s, 0.0)
    signal, said = read(stamps, arrivals(time, random, 2e-4))
    assert [s.partition(":")[0] for s in said] == ["clock_stepped"]
    assert "once" in said[0]
    assert signal.time.size == SAMPLES
    np.testing.assert_allclose(signal.time, time, atol=3e-4)
