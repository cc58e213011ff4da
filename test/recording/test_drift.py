"""A clock that runs fast is told by the times of reception, and taken out; clocks that keep pace are left alone."""

import numpy as np
import pytest

from flex_ident.notices import Code
from flex_ident.recording.clocks import RawSignal, signals_of
from flex_ident.recording.drift import drift_between
from flex_ident.report.sentences import sentence

EPOCH = 1_700_000_000_000_000_000
LATE_S = 3e-4


def raw(topic: str, seed: int, *, ppm: float = 0.0, seconds: float = 30.0, rate: float = 500.0) -> RawSignal:
    random = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 1.0 / rate)
    received = np.maximum.accumulate(time + 2e-4 + LATE_S * random.exponential(size=time.size))
    stamps = time * (1.0 + 1e-6 * ppm)
    ns = (EPOCH + np.rint(t * 1e9).astype(np.int64) for t in (received, stamps))
    return RawSignal(f"/{topic}:joint.position", *ns, np.sin(3.0 * time))


@pytest.mark.parametrize("ppm", [-200.0, -50.0, 20.0, 50.0, 1000.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_clock_that_drifts_is_brought_back(ppm: float, seed: int) -> None:
    motor, torque = raw("a", seed), raw("a", seed)
    link = raw("b", seed + 10, ppm=ppm)
    found = drift_between(link, motor)
    assert found is not None
    assert abs(1e6 * found.rate - ppm) < 4.0 * 1e6 * found.std + 0.002 * abs(ppm)
    signals, notices, _ = signals_of(
        {"motor_position": motor, "motor_torque": torque, "link_position": link}, joint="j"
    )
    assert [n.code for n in notices] == [Code.CLOCK_DRIFT]
    assert ("fast" if ppm > 0 else "slow") in sentence(notices[0])
    by_role = {s.role: s for s in signals}
    late = by_role["link_position"].time - by_role["motor_position"].time
    assert np.ptp(late) < 2e-4


@pytest.mark.parametrize("seed", range(12))
def test_clocks_that_keep_pace_are_left_alone(seed: int) -> None:
    motor, link = raw("a", seed), raw("b", seed + 100)
    signals, notices, _ = signals_of({"motor_position": motor, "motor_torque": motor, "link_position": link}, joint="j")
    assert notices == []
    np.testing.assert_array_equal(signals[0].time, signals[2].time)


def test_without_stamps_or_with_few_messages_nothing_is_said() -> None:
    motor = raw("a", 1)
    bare = RawSignal("/b:joint.position", motor.received, np.zeros_like(motor.stamps), motor.values)
    assert drift_between(bare, motor) is None
    short = raw("b", 2, ppm=500.0, seconds=0.5)
    assert drift_between(short, motor) is None
