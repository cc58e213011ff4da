"""Readings that come too late, too seldom or in another time than that of the commands."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from servo import CHIRP, LIMITS, RATE_HZ, Servo, commands_stay_inside, servo, started

from flex_ident.excitation import Gains, JointSample, Limits

STIFF = Gains(150.0, 15.0, (30.0,), (3.0,))


def thinned_out(made: Servo, period_s: float) -> None:
    """Let one reading come in that time from now on."""
    latest = made.now

    def sample(s: JointSample) -> JointSample | None:
        nonlocal latest
        if s.received - latest < period_s:
            return None
        latest = s.received
        return s

    made.sample = sample


def old(made: Servo, age: float) -> None:
    """Let readings come that are as old as that."""
    made.sample = lambda s: replace(s, stamp=s.received - age, age=age)
    for _ in range(100):
        made.tick()


@pytest.mark.parametrize("period_s", [0.1, 0.06, 0.03])
def test_a_joint_under_efforts_whose_readings_thin_out_is_let_go_in_time(period_s: float) -> None:
    made = started(interface="effort", gains=STIFF, state_timeout_s=0.6)
    made.run(2.5)
    assert made.exciter.state == "exciting"
    thinned_out(made, period_s)
    output = made.run(4.0)
    assert output.state == "aborted"
    assert "the joint states have thinned out" in output.reason
    assert max(abs(o.position) for _, o in made.outputs) < LIMITS.position_max
    assert abs(made.velocity) < 0.02
    commands_stay_inside(made)


@pytest.mark.parametrize("interface", ["position", "velocity"])
def test_what_is_not_closed_over_them_by_force_goes_on(interface: str) -> None:
    made = started(interface=interface, state_timeout_s=0.6)
    made.run(2.5)
    thinned_out(made, 0.1)
    assert made.run(4.0).state == "done"
    commands_stay_inside(made)


def test_pauses_are_no_thinning() -> None:
    made = started(interface="effort", gains=STIFF, state_timeout_s=0.6)
    made.run(2.0)
    for _ in range(6):
        thinned_out(made, 0.04)
        made.run(0.05)
        made.sample = lambda s: s
        made.run(0.1)
    assert made.exciter.state == "exciting", made.exciter.reason


@pytest.mark.parametrize(
    ("interface", "gains", "age", "allowed"),
    [
        ("effort", STIFF, 0.07, "0.06"), ("effort", STIFF, 0.05, ""),
        ("velocity", Gains(5.0, 0.0), 0.15, "0.10"), ("velocity", Gains(5.0, 0.0), 0.08, ""),
        ("velocity", Gains(0.0, 0.0), 0.5, ""), ("position", STIFF, 0.5, ""),
    ],
)  # fmt: skip
def test_no_loop_is_closed_over_old_readings(interface: str, gains: Gains, age: float, allowed: str) -> None:
    made = servo(interface=interface, gains=gains, state_timeout_s=0.6)
    made.exciter = type(made.exciter)(made.exciter.settings, made.exciter.reference, made.exciter.limits)
    old(made, age)
    why = made.exciter.objection(made.now)
    if allowed:
        assert f"are {age:.2f} s old when they come, {allowed} s allowed where {interface} is closed over them" in why
    else:
        assert why == ""


def test_a_single_late_reading_is_not_all_of_them() -> None:
    made = servo(interface="effort", gains=STIFF)
    made.exciter = type(made.exciter)(made.exciter.settings, made.exciter.reference, made.exciter.limits)
    old(made, 0.001)
    now = made.now + 0.08
    made.exciter.observe(JointSample(now, now - 0.08, 0.0, 0.0, 1.0, (0.7,), (0.0,), (2.0,), ("elbow",), age=0.08))
    assert made.exciter.objection(made.now) == ""


def test_no_effort_is_closed_over_ten_readings_a_second() -> None:
    made = servo(interface="effort", gains=STIFF, state_timeout_s=0.6)
    made.exciter = type(made.exciter)(made.exciter.settings, made.exciter.reference, made.exciter.limits)
    thinned_out(made, 0.1)
    made.run(2.0)
    assert "come at 10 Hz, effort that is closed over them needs 33 Hz" in made.exciter.objection(made.now)


@pytest.mark.parametrize(("pace", "said"), [(0.5, "0.50"), (2.0, ""), (0.0, "0.00"), (0.98, ""), (1.0, "")])
@pytest.mark.parametrize("epoch", [0.0, 100.0])
def test_nothing_moves_in_a_time_slower_than_that_of_the_commands(pace: float, said: str, epoch: float) -> None:
    made = servo(state_timeout_s=5.0)
    made.exciter = type(made.exciter)(made.exciter.settings, made.exciter.reference, made.exciter.limits)
    began = made.now
    made.sample = lambda s: replace(s, stamp=epoch + pace * (s.received - began), age=math.nan)
    made.run(3.0)
    why = made.exciter.objection(made.now)
    assert (f"time passes at {said} of real time" in why) if said else why == ""


@pytest.mark.parametrize("interface", ["position", "velocity", "effort"])
def test_a_start_before_the_pace_is_known_ends_once_it_is(interface: str) -> None:
    made = servo(interface=interface, state_timeout_s=5.0)
    began = made.now
    made.sample = lambda s: replace(s, stamp=0.5 * (s.received - began), age=math.nan)
    made.run(0.4)
    assert made.exciter.start(made.now) == ""
    output = made.run(2.0)
    assert output.state == "aborted"
    assert "time passes at 0.50 of real time" in output.reason
    assert abs(made.position) < 0.05
    commands_stay_inside(made)


def test_a_clock_that_was_set_is_no_other_pace() -> None:
    made = servo()
    made.run(1.5)
    made.sample = lambda s: replace(s, stamp=s.stamp + 5.0)
    made.run(1.5)
    assert made.exciter.objection(made.now) == ""


@pytest.mark.parametrize("silence_s", [0.05, 0.1, 0.3, 0.55])
@pytest.mark.parametrize("begin", [1.5, 1.86, 2.7, 3.6])
def test_a_joint_under_efforts_that_is_not_seen_for_a_while_is_neither_pushed_on_nor_thrown_back(
    silence_s: float, begin: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A joint of little friction, which nothing holds meanwhile, in the middle of a chirp up to 20 Hz."""
    monkeypatch.setattr("servo.INERTIA", 1.0)
    limits, chirp = Limits(-0.4, 0.4, 2.0, 60.0, 0.5), replace(CHIRP, duration_s=6.0, amplitude=0.2, fade_s=1.0)
    made = started(
        interface="effort", gains=Gains(300.0, 30.0, (30.0,), (3.0,)), state_timeout_s=0.6, limits=limits, chirp=chirp
    )
    made.run(begin)
    made.sample = lambda s: None
    begun = made.now
    speed = way = 0.0
    while made.now < begun + 3.0:
        if made.now > begun + silence_s:
            made.sample = lambda s: s
        made.tick()
        speed, way = max(speed, abs(made.velocity)), max(way, abs(made.position))
    assert made.exciter.reason == ""
    assert speed < limits.velocity
    assert way < limits.position_max


def fall_behind(made: Servo, behind_s: float, at_once_s: float = 0.2) -> list[float]:
    """Let readings come late by that from now on, and now and then all at once; the speeds that come of it."""
    waiting: list[JointSample] = []
    speeds: list[float] = []

    def sample(s: JointSample) -> JointSample | None:
        waiting.append(s)
        speeds.append(s.velocity)
        at_once = len(speeds) % round(at_once_s * RATE_HZ) == 0
        due = [w for w in waiting if at_once or s.received - w.stamp >= behind_s]
        del waiting[: len(due)]
        return replace(due[-1], received=s.received, age=s.received - due[-1].stamp) if due else None

    made.sample = sample
    return speeds


@pytest.mark.parametrize("behind_s", [0.01, 0.02, 0.03, 0.04, 0.05])
def test_a_joint_under_efforts_whose_readings_fall_behind_stays_below_its_speed_limit(behind_s: float) -> None:
    made = started(interface="effort", gains=STIFF, state_timeout_s=0.6)
    made.run(2.0)
    assert made.exciter.state == "exciting"
    speeds = fall_behind(made, behind_s)
    made.run(6.0)
    assert max(map(abs, speeds)) <= LIMITS.velocity


def test_a_joint_whose_efforts_late_readings_hold_back_is_not_said_to_have_an_inactive_controller() -> None:
    made = started(interface="effort", gains=STIFF, state_timeout_s=0.6)
    made.run(2.0)
    fall_behind(made, 0.055, at_once_s=10.0)
    output = made.run(6.0)
    assert output.state == "aborted"
    assert "too far behind" in output.reason
