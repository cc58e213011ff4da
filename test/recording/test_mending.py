"""Faults are found, mended and counted; clean signals, smooth or noisy, coarse or fine, are left alone."""

from dataclasses import replace

import numpy as np
import pytest

from flex_ident.notices import Notice
from flex_ident.recording import Floats, Signal
from flex_ident.recording.holds import freezes, samples_per_update
from flex_ident.recording.mending import mended_signals
from flex_ident.recording.recording import Role
from flex_ident.report.sentences import sentence

RATES = (100.0, 250.0, 500.0, 1000.0, 4000.0)
ENCODERS = (0.0, 1e-6, 2 * np.pi / 4096 / 100, 2 * np.pi / 4096)
EFFORTS = (0.0, 0.01, 0.5)
NOISES = (0.0, 0.05, 1.0)
SECONDS = 12.0
FASTEST_HZ = 12.0


def rounded(values: Floats, step: float) -> Floats:
    return np.rint(values / step) * step if step else values


def signals(
    rate: float, *, encoder: float = 1e-6, step: float = 0.0, noise: float = 0.05, seed: int = 0, rest_s: float = 1.5,
    motion: str = "chirp",
) -> list[Signal]:  # fmt: skip
    """A joint at rest, moving along a chirp or at steady speeds, and at rest again; effort with friction."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, SECONDS, 1.0 / rate)
    moving = np.clip((time - rest_s) / (SECONDS - 2 * rest_s), 0.0, 1.0)
    fastest = min(FASTEST_HZ, 0.1 * rate)
    if motion == "chirp":
        phase = 2 * np.pi * (SECONDS - 2 * rest_s) * (0.2 * moving + (fastest - 0.2) * moving**2 / 2)
        window = np.clip(10 * moving, 0, 1) * np.clip(10 * (1 - moving), 0, 1)
        position = 0.7 + window * 0.3 * np.sin(phase)
    else:
        position = 0.7 + 0.4 * np.abs((4 * moving) % 2 - 1)
    smooth = np.hanning(max(5, int(0.1 * rate)))
    padded = np.pad(position, smooth.size, mode="edge")
    position = np.convolve(padded, smooth / smooth.sum(), mode="same")[smooth.size : -smooth.size]
    position = np.rint(position * 1e12) / 1e12  # at rest it rests: no rounding moves it
    velocity = np.gradient(position, time)
    acceleration = np.gradient(velocity, time)
    effort = 2.0 * acceleration + 5.0 * velocity + 4.0 * np.tanh(velocity / 0.005) + 20.0 * np.cos(position)
    link = position - effort / 20000.0
    effort = rounded(effort + noise * random.standard_normal(time.size), step)
    made: dict[Role, Floats] = {
        "motor_position": rounded(position, encoder), "link_position": rounded(link, encoder), "motor_torque": effort,
    }  # fmt: skip
    return [Signal(role, f"/joint_states:j.{role}", "header", time, values) for role, values in made.items()]


def with_values(given: list[Signal], role: Role, values: Floats) -> list[Signal]:
    return [replace(s, values=values) if s.role == role else s for s in given]


def of(given: list[Signal], role: Role) -> Signal:
    return next(s for s in given if s.role == role)


def codes(notices: list[Notice]) -> list[str]:
    return sorted(n.code for n in notices)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("encoder", ENCODERS)
@pytest.mark.parametrize("motion", ["chirp", "steady"])
def test_clean_signals_are_left_alone(rate: float, encoder: float, motion: str) -> None:
    for step in EFFORTS:
        for noise in NOISES:
            given = signals(rate, encoder=encoder, step=step, noise=noise, motion=motion)
            found, notices = mended_signals(given)
            assert [sentence(n) for n in notices] == [], (step, noise)
            for before, after in zip(given, found, strict=True):
                np.testing.assert_array_equal(before.values, after.values)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("encoder", ENCODERS)
@pytest.mark.parametrize("noise", [1e-6, 1e-4, 3e-3, 0.03])
def test_noisy_positions_are_left_alone(rate: float, encoder: float, noise: float) -> None:
    for seed in range(4):
        random = np.random.default_rng(seed)
        given = [
            s if s.role == "motor_torque" else
            replace(s, values=rounded(s.values + noise * random.standard_normal(s.values.size), encoder))
            for s in signals(rate, seed=seed, rest_s=(0.0, 1.5)[seed % 2] + 1e-3)
        ]  # fmt: skip
        _, notices = mended_signals(given)
        assert [sentence(n) for n in notices] == []


@pytest.mark.parametrize("rate", RATES[1:])
@pytest.mark.parametrize("share", [0.001, 0.01, 0.03])
@pytest.mark.parametrize("role", ["motor_position", "motor_torque"])
@pytest.mark.parametrize("constant", [0.0, 3.5])
def test_constants_in_between_are_left_out_and_counted(rate: float, share: float, role: Role, constant: float) -> None:
    random = np.random.default_rng(1)
    given = signals(rate, step=0.01 if constant else 0.0)
    truth = of(given, role).values
    hit = random.random(truth.size) < share
    hit[[0, 1, -2, -1]] = False
    if constant and np.count_nonzero(hit) < 8:
        pytest.skip("another constant is only told when it recurs")
    far = np.abs(truth - constant) > 0.05 * np.ptp(truth)
    found, notices = mended_signals(with_values(given, role, np.where(hit, constant, truth)))
    assert codes(notices) == ["isolated_values"]
    left = of(found, role)
    wrong = np.isin(left.time, of(given, role).time[hit & far])
    assert np.count_nonzero(wrong) <= 1 + 0.04 * np.count_nonzero(hit & far)
    dropped = truth.size - left.values.size
    assert f"{dropped} of {truth.size} values" in sentence(notices[0])
    assert dropped <= np.count_nonzero(hit)
    good = np.isin(of(given, role).time, left.time)
    assert np.count_nonzero(~good & ~hit) == 0


def test_a_second_publisher_of_zeros_is_named() -> None:
    given = []
    for signal in signals(500.0):
        time = np.sort(np.concatenate((signal.time, signal.time + 0.0011)))
        values = np.zeros(time.size)
        values[np.searchsorted(time, signal.time)] = signal.values
        given.append(replace(signal, time=time, values=values))
    found, notices = mended_signals(given)
    assert [c for c in codes(notices) if c != "spikes"] == ["isolated_values"] * 3  # one at the very end is a spike
    assert "second node" in sentence(notices[0])
    for signal in signals(500.0):
        left = of(found, signal.role)
        kept = np.interp(signal.time, left.time, left.values)
        np.testing.assert_allclose(kept[1:-2], signal.values[1:-2], atol=1e-3 if "position" in signal.role else 25.0)
        assert np.count_nonzero(left.values == 0.0) < 0.02 * signal.values.size


@pytest.mark.parametrize("rate", RATES[1:])
@pytest.mark.parametrize("role", ["motor_position", "motor_torque"])
def test_spikes_are_left_out_and_counted(rate: float, role: Role) -> None:
    random = np.random.default_rng(2)
    given = signals(rate)
    values = of(given, role).values.copy()
    hit = random.choice(np.arange(2, values.size - 2, 3), 10, replace=False)
    values[hit] += np.where(random.random(10) < 0.5, -1, 1) * 3.0 * np.ptp(values)
    found, notices = mended_signals(with_values(given, role, values))
    assert codes(notices) == ["spikes"]
    assert f"10 of {values.size} values" in sentence(notices[0])
    assert not np.isin(of(given, role).time[hit], of(found, role).time).any()


@pytest.mark.parametrize("rate", RATES[1:])
@pytest.mark.parametrize("seam", [2 * np.pi, np.pi, 0.5, 0.2])
@pytest.mark.parametrize("encoder", ENCODERS)
def test_positions_that_wrap_are_continued(rate: float, seam: float, encoder: float) -> None:
    given = signals(rate, encoder=encoder)
    truth = of(given, "motor_position").values
    if np.abs(np.diff(truth)).max() > seam / 12:
        pytest.skip("too fast for this seam at this rate")
    low = 0.75 - seam / 2
    wrapped = (truth - low) % seam + low
    jumps = int(np.count_nonzero(np.abs(np.diff(wrapped - truth)) > 0.5 * seam))
    found, notices = mended_signals(with_values(given, "motor_position", wrapped))
    values = of(found, "motor_position").values
    if not jumps:
        assert notices == []
        return
    assert codes(notices) == ["position_unwrapped"]
    np.testing.assert_allclose(values - values[0], truth - truth[0], atol=1e-3 * seam + 2 * encoder)


@pytest.mark.parametrize("rate", RATES[1:])
@pytest.mark.parametrize("size", [0.02, -0.1, 1.0])
@pytest.mark.parametrize("at_s", [0.5, 3.0, 9.0])
def test_a_new_zero_is_taken_back(rate: float, size: float, at_s: float) -> None:
    given = signals(rate)
    signal = of(given, "motor_position")
    values = signal.values + np.where(signal.time > at_s, size, 0.0)
    found, notices = mended_signals(with_values(given, "motor_position", values))
    left = of(found, "motor_position").values
    steps = np.abs(np.diff(signal.values))
    hidden = abs(size) < 20 * steps[np.abs(signal.time[1:] - at_s) < 0.05].max()
    if notices or not hidden:
        assert codes(notices) == ["position_rezeroed"]
        assert "jumps once" in sentence(notices[0])
        np.testing.assert_allclose(left, signal.values, atol=0.2 * abs(size))


@pytest.mark.parametrize("rate", [250.0, 500.0, 1000.0])
@pytest.mark.parametrize("ratio", [1.25, 1.6, 2.0, 2.5, 3.0, 4.0, 10.0])
@pytest.mark.parametrize("step", [0.0, 0.01])
@pytest.mark.parametrize("role", ["motor_torque", "link_position"])
def test_held_samples_are_found_and_the_true_rate_is_used(rate: float, ratio: float, step: float, role: Role) -> None:
    given = signals(rate, step=step, noise=0.2)
    signal = of(given, role)
    measured = np.floor(np.arange(signal.time.size) / ratio) * ratio
    source = np.minimum(np.ceil(measured - 1e-9).astype(int), signal.time.size - 1)
    found, notices = mended_signals(with_values(given, role, signal.values[source]))
    assert codes(notices) == ["held_samples"]
    left = of(found, role)
    fresh = np.unique(source)
    moving = (signal.time > 2.0) & (signal.time < 10.0)
    right = np.isin(left.time[(left.time > 2.0) & (left.time < 10.0)], signal.time[fresh])
    assert np.mean(right) > 0.97
    assert np.count_nonzero(right) > 0.9 * np.count_nonzero(moving[fresh])


def test_a_coarse_held_effort_is_found_by_the_phase_of_its_changes() -> None:
    given = signals(500.0, step=1.0, noise=0.6)
    signal = of(given, "motor_torque")
    held = signal.values[np.arange(signal.time.size) // 4 * 4]
    _, notices = mended_signals(with_values(given, "motor_torque", held))
    assert codes(notices) == ["held_samples"]
    assert "measured at 125 Hz" in sentence(notices[0])


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("step", [0.0, 0.01, 0.1])
@pytest.mark.parametrize("seconds", [0.4, 3.0])
def test_an_effort_that_freezes_in_motion_is_left_out(rate: float, step: float, seconds: float) -> None:
    given = signals(rate, step=step)
    signal = of(given, "motor_torque")
    frozen = (signal.time >= 5.0) & (signal.time < 5.0 + seconds)
    values = np.where(frozen, signal.values[np.argmax(frozen)], signal.values)
    found, notices = mended_signals(with_values(given, "motor_torque", values))
    assert codes(notices) == ["effort_frozen"]
    left = of(found, "motor_torque").time
    assert np.count_nonzero((left > 5.0 + 1 / rate) & (left < 5.0 + seconds - 1 / rate)) == 0
    assert left.size >= np.count_nonzero(~frozen)
    assert "stands still once" in sentence(notices[0])


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_a_coarse_effort_that_stays_on_one_step_is_no_frozen_one(share: float) -> None:
    """Slow motion about a step's middle: the effort is the same for long while the joint turns round."""
    time = of(signals(500.0), "motor_torque").time
    position = 0.3 * np.sin(0.4 * np.pi * time)
    effort = 20.0 * np.sin(2.0 * np.pi * 1.7 * np.maximum(time - 6.0, 0.0)) + 8.0 * np.sin(0.4 * np.pi * time)
    step = share * float(np.ptp(effort))
    given = with_values(signals(500.0), "motor_torque", np.round(effort / step) * step)
    given = with_values(given, "motor_position", position)
    _, notices = mended_signals(given)
    assert "effort_frozen" not in codes(notices)


def test_an_effort_that_a_protective_stop_freezes_at_rest_is_left_out() -> None:
    given = signals(500.0, encoder=1e-5)
    time = of(given, "motor_torque").time
    stopped = time > 8.0
    position, torque = of(given, "motor_position").values, of(given, "motor_torque").values
    given = with_values(given, "motor_position", np.where(stopped, position[np.argmax(stopped)], position))
    given = with_values(given, "motor_torque", np.where(stopped, torque[np.argmax(stopped)], torque))
    found, notices = mended_signals(given)
    assert codes(notices) == ["effort_frozen"]
    assert of(found, "motor_torque").time[-1] < 8.01


@pytest.mark.parametrize("ratio", [1.25, 4.0 / 3.0, 1.7, 2.5])
def test_values_that_waited_for_their_message_are_put_back(ratio: float) -> None:
    """A driver that measures by a clock of its own: each message holds its last value, up to a message's time old."""
    clean = signals(500.0, noise=0.05)
    at = np.arange(clean[0].time.size, dtype=np.float64)
    measured = np.floor(at / ratio + 1e-9) * ratio
    given = [replace(s, values=np.interp(measured, at, s.values)) for s in clean]
    found, notices = mended_signals(given)
    assert codes(notices) == ["held_samples"] * 3
    for before, after in zip(clean, found, strict=True):
        inside = (after.time > 2.0) & (after.time < 10.0)
        due = np.interp(after.time[inside], before.time, before.values)
        scale = float(np.ptp(before.values))
        assert float(np.std(after.values[inside] - due)) < 0.005 * scale


@pytest.mark.parametrize("role", ["motor_position", "link_position"])
@pytest.mark.parametrize("size", [0.3, 3.0, 100.0])
def test_small_spikes_and_pairs_of_them_in_a_position_are_left_out(role: Role, size: float) -> None:
    random = np.random.default_rng(3)
    given = signals(500.0)
    values = of(given, role).values.copy()
    hit = random.choice(np.arange(20, values.size - 20, 7), 12, replace=False)
    hit = np.concatenate((hit, hit[:4] + 1))
    values[hit] += size * np.ptp(values) * random.uniform(0.6, 1.4, 16)
    found, notices = mended_signals(with_values(given, role, values))
    assert codes(notices) == ["spikes"]
    assert not np.isin(of(given, role).time[hit], of(found, role).time).any()


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("sticks", [False, True])
def test_a_joint_polled_when_the_line_is_free_does_not_jump(seed: int, sticks: bool) -> None:
    """Steps as far as the joint moves during a late answer are motion, also where it sticks most of the time."""
    random = np.random.default_rng(seed)
    steps = 0.02 + random.exponential(0.01, 3000) + 0.1 * (random.random(3000) < 0.06)
    time = np.cumsum(steps)
    position = 0.3 * np.sin(0.25 * time) + 0.02 * np.sin(1.7 * time)
    if sticks:
        position = np.where(np.sin(1.3 * time) > 0.3, position, np.round(position / 0.03) * 0.03)
        position = np.convolve(np.pad(position, 2, mode="edge"), np.ones(5) / 5.0, mode="valid")
    position = rounded(position, 2 * np.pi / 16384)
    effort = random.standard_normal(time.size)
    given = [
        Signal("motor_position", "/joint_states:j.position", "header", time, position),
        Signal("motor_torque", "/joint_states:j.effort", "header", time, effort),
    ]
    found, notices = mended_signals(given)
    assert "position_rezeroed" not in codes(notices)
    kept = of(found, "motor_position")
    np.testing.assert_array_equal(kept.values, position[np.isin(time, kept.time)])


@pytest.mark.parametrize("width", [7, 11, 15])
def test_a_joint_that_is_pushed_from_rest_to_rest_does_not_jump(width: int) -> None:
    """A push lasts some samples, its fastest step lies far off those of the rests around it, and moves on smoothly."""
    random = np.random.default_rng(width)
    time, speed, way = np.arange(4000) / 250.0, np.zeros(4000), 0.0
    for first in np.cumsum(random.integers(60, 90, 40)):
        push = random.uniform(0.2, 1.5) * (1.0 if way <= 0.0 else -1.0)
        speed[first : first + width] += 0.003 * push * np.hanning(width + 2)[1:-1]
        way += push
    position = rounded(np.cumsum(speed), 3.8e-5)
    given = [
        Signal("motor_position", "/joint_states:j.position", "header", time, position),
        Signal("motor_torque", "/joint_states:j.effort", "header", time, random.standard_normal(4000)),
    ]
    found, notices = mended_signals(given)
    assert "position_rezeroed" not in codes(notices)
    np.testing.assert_array_equal(of(found, "motor_position").values, position)


@pytest.mark.parametrize("rate", [100.0, 200.0, 500.0])
@pytest.mark.parametrize("held", [2, 4, 8])
def test_a_step_after_held_samples_makes_up_for_them(rate: float, held: int) -> None:
    """A publisher that stands still for a few samples now and then, and goes on where the joint is meanwhile."""
    random = np.random.default_rng(held)
    given = signals(rate, motion="steady")
    signal = of(given, "motor_position")
    values = signal.values.copy()
    starts = random.choice(np.arange(int(2.0 * rate), int(10.0 * rate)), 12, replace=False)
    for k in starts.tolist():
        values[k : k + held + 1] = values[k]
    _, notices = mended_signals(with_values(given, "motor_position", values))
    assert "position_rezeroed" not in codes(notices)


@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_a_torque_in_steps_is_not_frozen(rate: float) -> None:
    """A joint pushed to and fro by torques that are held for seconds."""
    time = np.arange(0.0, 16.0, 1.0 / rate)
    torque = np.where((time // 2.0) % 2 == 0, 3.0, -3.0)
    torque[:3] = 0.0, 1.0, 2.0
    velocity = np.cumsum(torque - 1.5 * np.sin(np.pi * time / 2.0)) / rate / 4.0
    position = np.cumsum(velocity - velocity.mean()) / rate
    given = [
        Signal("motor_position", "/joint_states:j.position", "header", time, position),
        Signal("motor_torque", "/joint_states:j.effort", "header", time, torque),
    ]
    found, notices = mended_signals(given)
    assert codes(notices) == []
    np.testing.assert_array_equal(of(found, "motor_torque").values, torque)


def test_an_effort_that_is_clipped_is_neither_held_nor_frozen() -> None:
    """A drive at its limit was said to measure at 442 of 500 Hz, and the samples at the limit were left out."""
    time = np.arange(20000) / 1000.0
    noise = 0.2 * np.random.default_rng(3).standard_normal(time.size)
    asked = 40.0 * np.sin(2.0 * np.pi * (0.5 + 0.4 * time) * time) + noise
    clipped = np.clip(asked, -25.0, 25.0)
    assert samples_per_update(clipped) == 1.0
    assert freezes(clipped, np.sin(time), 1e-3) == []
    held = np.repeat(clipped[::2], 2)
    assert samples_per_update(held) == pytest.approx(2.0, abs=0.05)
