"""A clock that jumped back, its bag sorted by time: the stretches that lie over each other are found and left out."""

import numpy as np
import pytest

from flex_ident.notices import Code
from flex_ident.recording.laid_over import without_laid_over
from flex_ident.recording.raw import RawSignal


def recorded(back_s: float = 3.0, at: float = 0.6, *, jitter: float = 0.1, noise: float = 1e-4, seed: int = 0) -> dict:
    """Twelve seconds at 500 Hz whose clock goes back in between, messages in the order of their times."""
    rng = np.random.default_rng(seed)
    n, period = 6000, 0.002
    true = period * (np.arange(n) + jitter * rng.uniform(-0.5, 0.5, n))
    position = 0.3 * np.sin(2.0 * np.pi * (0.5 + 0.2 * true) * true) + noise * rng.normal(size=n)
    torque = 2.0 * np.cos(2.0 * np.pi * 0.7 * true)
    clock = true - back_s * (np.arange(n) >= at * n)
    stamps = (1.7e18 + 1e9 * clock).astype(np.int64)
    order = np.argsort(stamps, kind="stable")
    return {
        role: RawSignal(f"/joint_states:{role}", stamps[order] + 300_000, stamps[order], values[order])
        for role, values in (("motor_position", position), ("motor_torque", torque))
    }


@pytest.mark.parametrize(("back_s", "at"), [(3.0, 0.6), (3.0, 0.4), (0.7, 0.5), (5.0, 0.5)])
@pytest.mark.parametrize("seed", range(3))
def test_the_longer_stretch_is_kept_and_it_is_said_when_and_by_how_much(back_s: float, at: float, seed: int) -> None:
    given = recorded(back_s, at, seed=seed)
    kept, [notice] = without_laid_over(given)
    assert notice.code is Code.TIME_JUMPED_BACK
    assert notice.numbers["largest_s"] == pytest.approx(back_s, abs=0.2)
    assert notice.numbers["at_s"] == pytest.approx(12.0 * at, abs=0.2)
    longer = max(at * 12.0 - back_s, 12.0 * (1.0 - at) - back_s)
    time = 1e-9 * kept["motor_torque"].received
    assert np.ptp(time) == pytest.approx(longer, abs=0.3)
    assert float(np.diff(time).min()) > 0.001
    assert kept["motor_position"].values.size == notice.numbers["kept"]


@pytest.mark.parametrize("jitter", [0.0, 0.9])
def test_a_recording_without_a_jump_is_as_it_is(jitter: float) -> None:
    given = recorded(0.0, jitter=jitter)
    kept, notices = without_laid_over(given)
    assert notices == []
    assert kept == given


def test_messages_that_were_held_up_or_come_faster_for_a_while_are_no_jump() -> None:
    rng = np.random.default_rng(1)
    time = np.cumsum(np.where((np.arange(6000) > 2000) & (np.arange(6000) < 4000), 0.001, 0.002))
    position = 0.3 * np.sin(3.0 * time) + 1e-5 * rng.normal(size=time.size)
    stamps = (1.7e18 + 1e9 * time).astype(np.int64)
    given = {role: RawSignal(role, stamps, stamps, position) for role in ("motor_position", "motor_torque")}
    assert without_laid_over(given)[1] == []
