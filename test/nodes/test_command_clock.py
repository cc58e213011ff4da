"""Ticks skip, never pile up; and how late they were is told."""

import time
from itertools import pairwise

import pytest

from flex_ident.nodes.command_clock import CommandClock, Punctuality


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


def test_punctuality_in_words() -> None:
    counted = Punctuality(100.0)
    assert "no commands" in str(counted)
    for k in range(101):
        counted.add(0.01 * k, 1e-3 if k == 50 else 1e-5, 2 if k == 50 else 0)
    assert counted.achieved_hz == pytest.approx(100.0)
    assert str(counted) == (
        "101 commands at 100.0 of 100 Hz, 2 skipped; jitter 10 us (50 %), 10 us (99 %), 1000 us (most)"
    )
