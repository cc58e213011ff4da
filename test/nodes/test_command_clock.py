"""Ticks skip, never pile up; and how late they were is told."""

import os
import threading
import time
from itertools import pairwise

import pytest

from flex_ident.nodes.command_clock import CommandClock, Punctuality, RosTime, threads_in_real_time


def test_late_ticks_skip_and_stay_on_the_grid() -> None:
    seen: list[tuple[float, float, int]] = []

    def tick(now: float, late: float, skipped: int) -> bool:
        seen.append((now, late, skipped))
        if len(seen) == 20:
            time.sleep(0.055)
        return len(seen) < 60

    clock = CommandClock(100.0, tick)
    clock.start()
    time.sleep(1.5)
    assert not clock.ticking
    assert clock.error is None
    assert sum(skipped for _, _, skipped in seen) >= 4
    due = [now - late for now, late, _ in seen]
    steps = [(b - a) * 100.0 for a, b in pairwise(due)]
    assert all(abs(step - round(step)) < 1e-6 and step > 0.5 for step in steps)
    assert steps[19] >= 5.0 or seen[20][2] >= 4


def test_a_tick_that_raises_ends_the_clock_and_is_kept() -> None:
    clock = CommandClock(1000.0, lambda *_: 1 / 0 > 0)
    clock.start()
    time.sleep(0.2)
    assert not clock.ticking
    assert isinstance(clock.error, ZeroDivisionError)


@pytest.mark.skipif(not hasattr(os, "sched_getscheduler"), reason="no such priorities here")
def test_threads_of_a_node_have_a_priority_that_its_start_has_not() -> None:
    policies: list[int] = []
    before = os.sched_getscheduler(0)
    with threads_in_real_time(5):
        given = os.sched_getscheduler(0)
        thread = threading.Thread(target=lambda: policies.append(os.sched_getscheduler(0)))
        thread.start()
        thread.join()
    if given != os.SCHED_FIFO:
        pytest.skip("this user may not have real-time priority")
    assert policies == [os.SCHED_FIFO]
    assert os.sched_getscheduler(0) == before != os.SCHED_FIFO


def test_punctuality_in_words() -> None:
    counted = Punctuality(100.0)
    assert "no commands" in str(counted)
    for k in range(101):
        counted.add(0.01 * k, 1e-3 if k == 50 else 1e-5, 2 if k == 50 else 0)
    assert counted.achieved_hz == pytest.approx(100.0)
    assert str(counted) == (
        "101 commands at 100.0 of 100 Hz, 2 skipped; jitter 10 us (50 %), 10 us (99 %), 1000 us (most)"
    )


def test_stamps_are_even_where_readings_are_interrupted_and_follow_a_clock_that_is_set() -> None:
    steady_ns, ahead_ns = 5_000_000_000, 1_700_000_000_000_000_000

    def steady_now_ns() -> int:
        nonlocal steady_ns
        steady_ns += 400
        return steady_ns

    def ros_now_ns() -> int:
        nonlocal steady_ns
        steady_ns += interrupted_ns // 3
        now = steady_ns + ahead_ns
        steady_ns += interrupted_ns - interrupted_ns // 3
        return now

    clock = RosTime(ros_now_ns, steady_now_ns)
    stamps = []
    for k in range(100):
        interrupted_ns = 300_000 if k % 10 == 7 else 300
        steady_ns = 5_000_000_000 + 2_000_000 * k + 10_000
        stamps.append(clock.at(5.0 + 0.002 * k))
    assert all(abs(b - a - 2_000_000) < 1_000 for a, b in pairwise(stamps))
    assert stamps[-1] == pytest.approx(5_198_000_000 + ahead_ns, abs=2_000)
    ahead_ns += 40_000_000
    assert clock.at(1e-9 * steady_ns) == pytest.approx(steady_ns + ahead_ns, abs=2_000)
