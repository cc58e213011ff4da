"""What is dropped of a signal on the way from the bag, and which clock it lies on."""

import numpy as np
import pytest

from flex_ident.errors import SignalError
from flex_ident.recording import Floats, Signal
from flex_ident.recording.cleaning import cleaned_signal
from flex_ident.recording.clocks import RawSignal, signals_of
from flex_ident.report.sentences import sentence

TIME = 1e-3 * np.arange(1000)
VALUES = np.sin(TIME)
EPOCH = 1_700_000_000_000_000_000


def cleaned(time: Floats, values: Floats = VALUES) -> tuple[Signal, list[str]]:
    signal, notices = cleaned_signal("motor_position", "/t:j.position", "header", time, values)
    return signal, [n.code for n in notices]


def test_clean_signal_is_left_alone() -> None:
    signal, codes = cleaned(TIME)
    np.testing.assert_array_equal(signal.time, TIME)
    np.testing.assert_array_equal(signal.values, VALUES)
    assert codes == []


def test_what_is_no_number_is_dropped_and_counted() -> None:
    values = VALUES.copy()
    values[[3, 500, 700, 999]] = np.nan, np.inf, 1e300, -np.inf
    signal, codes = cleaned(TIME, values)
    assert signal.dropped_nonfinite == 4
    assert codes == ["nonfinite_values"]
    np.testing.assert_array_equal(signal.values, np.delete(VALUES, [3, 500, 700, 999]))


def test_duplicates_are_kept_once() -> None:
    order = np.repeat(np.arange(1000), np.where(np.arange(1000) % 100 == 5, 3, 1))
    signal, codes = cleaned(TIME[order], VALUES[order])
    np.testing.assert_array_equal(signal.time, TIME)
    assert (signal.dropped_duplicates, signal.dropped_backwards, codes) == (20, 0, ["duplicate_stamps"])


def test_a_message_sent_again_is_no_warning() -> None:
    order = np.repeat(np.arange(1000), np.where(np.arange(1000) == 5, 3, 1))
    signal, codes = cleaned(TIME[order], VALUES[order])
    assert (signal.dropped_duplicates, codes) == (2, [])


def test_stamps_that_advance_every_other_message_are_told() -> None:
    signal, notices = cleaned_signal("motor_position", "/t:j.position", "header", TIME // 2e-3 * 2e-3, VALUES)
    assert signal.time.size < 600
    assert "of 1000 messages of /t repeat the stamp before them" in sentence(notices[0])


def test_samples_out_of_order_are_dropped() -> None:
    order = np.arange(1000)
    order[[200, 201]] = order[[201, 200]]
    signal, codes = cleaned(TIME[order], VALUES[order])
    np.testing.assert_array_equal(signal.time, np.delete(TIME, 200))
    assert (signal.dropped_backwards, codes) == (1, ["stamps_out_of_order"])


@pytest.mark.parametrize("wrong", [1e9, -1e9, 0.5, 1e300, np.nan])
def test_single_damaged_stamp_costs_one_sample(wrong: float) -> None:
    time = TIME.copy()
    time[400] = wrong if abs(wrong) != 0.5 else time[400] + wrong
    signal, _ = cleaned(time)
    np.testing.assert_array_equal(signal.time, np.delete(TIME, 400))


def test_clock_that_was_set_back_keeps_the_longest_stretch() -> None:
    time = TIME.copy()
    time[300:] -= 3600.0
    signal, codes = cleaned(time)
    assert codes == ["time_jumped_back"]
    np.testing.assert_array_equal(signal.time, time[300:])
    assert signal.dropped_backwards == 300


def test_gap_is_no_damage() -> None:
    time = TIME.copy()
    time[300:] += 3600.0
    signal, codes = cleaned(time)
    assert (signal.time.size, codes) == (1000, [])


@pytest.mark.parametrize(
    ("time", "values", "text"),
    [
        (TIME[:0], VALUES[:0], "holds no messages"),
        (TIME, np.full(1000, np.nan), "none of 1000 values"),
        (np.zeros(1000), VALUES, "does not advance over 1000 messages"),
        (TIME[:1], VALUES[:1], "holds one message"),
    ],
)
def test_nothing_left_is_refused(time: Floats, values: Floats, text: str) -> None:
    with pytest.raises(SignalError, match=f"/t:j.position.* {text}|{text}"):
        cleaned(time, values)


def raw(stamps_s: Floats | None, *, received_s: Floats = TIME, latency_ns: int = 400_000) -> RawSignal:
    received = EPOCH + np.round(received_s * 1e9).astype(np.int64) + latency_ns
    none = np.zeros(received.size, np.int64)
    stamps = none if stamps_s is None else EPOCH + np.round(stamps_s * 1e9).astype(np.int64)
    return RawSignal("/t", received, stamps, np.sin(received_s))


def clocks(motor: RawSignal, torque: RawSignal) -> tuple[list[Signal], list[str]]:
    signals, notices, _ = signals_of({"motor_position": motor, "motor_torque": torque}, joint="j")
    return signals, [n.code for n in notices]


def test_stamps_are_preferred() -> None:
    signals, codes = clocks(raw(TIME - 2e-4), raw(TIME - 2e-4))
    assert {s.clock for s in signals} == {"header"}
    np.testing.assert_allclose(signals[1].time, TIME, atol=1e-9)
    assert codes == []


@pytest.mark.parametrize("stamps", [None, np.zeros(1000) - EPOCH * 1e-9, np.ones(1000)])
def test_stamps_that_are_not_set_or_stand_still_give_way(stamps: Floats | None) -> None:
    signals, codes = clocks(raw(stamps), raw(stamps))
    assert {s.clock for s in signals} == {"receive"}
    assert codes == ["receive_times"]


@pytest.mark.parametrize(
    ("stamps", "why"),
    [
        (np.zeros(1000) - EPOCH * 1e-9, "are not set"),
        (np.ones(1000), "stand still"),
        (-TIME, "decrease"),
        (1e-9 * np.arange(TIME.size), "lie 1 ns apart"),
        (1e-3 * TIME, "lie 1e+03 ns apart"),
    ],
)
def test_why_stamps_give_way_is_said(stamps: Floats, why: str) -> None:
    both = {"motor_position": raw(stamps), "motor_torque": raw(stamps)}
    _, notices, _ = signals_of(both, joint="j")
    assert f"header stamps of j {why}" in sentence(notices[0])


def test_one_signal_without_stamps_is_shifted_to_the_others() -> None:
    signals, codes = clocks(raw(TIME), raw(None))
    assert [s.clock for s in signals] == ["header", "receive"]
    np.testing.assert_allclose(signals[1].time, signals[0].time, atol=1e-9)
    assert codes == ["mixed_clocks"]


def test_clocks_of_different_machines_are_brought_together() -> None:
    """The torque's driver stamps with the time since it was switched on."""
    signals, codes = clocks(raw(TIME), raw(TIME - 1.6e9))
    assert {s.clock for s in signals} == {"header"}
    np.testing.assert_allclose(signals[1].time, signals[0].time, atol=1e-6)
    assert codes == ["different_clocks"]
