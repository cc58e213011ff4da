"""How fast efforts make a joint, learned while it moves; and what that allows them."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

from flex_ident.excitation.agility import Agility

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from effort_stalls import POSITION_LIMIT, played


def moved(inertia: float, friction: float, *, late: float = 0.0) -> Agility:
    """A joint that efforts of a growing frequency have moved for 3 s, read at 500 Hz."""
    made, speed = Agility(), 0.0
    for k in range(3000):
        now = 1e-3 * k
        effort = 5.0 * math.sin(20.0 * now * (1.0 + now))
        if k % 2 == 0:
            made.observe(now, now - late, speed, effort)
        speed += (effort - friction * math.tanh(100.0 * speed)) / inertia * 1e-3
    return made


@pytest.mark.parametrize("inertia", [0.01, 1.0, 50.0])
def test_it_is_the_inverse_of_the_inertia(inertia: float) -> None:
    assert moved(inertia, 0.0).per_effort == pytest.approx(1.0 / inertia, rel=0.1)
    assert moved(inertia, 0.5).per_effort == pytest.approx(1.0 / inertia, rel=0.25)
    assert moved(inertia, 0.0, late=0.003).per_effort == pytest.approx(1.0 / inertia, rel=0.2)


def test_it_is_not_known_at_once_nor_without_speeds() -> None:
    made = Agility()
    for k in range(20):
        made.observe(1e-3 * k, 1e-3 * k, 0.1 * k, 1.0)
    assert made.per_effort == 0.0
    for k in range(1000):
        made.observe(1e-3 * k, 1e-3 * k, math.nan, 1.0)
    assert made.per_effort == 0.0


@pytest.mark.parametrize("seed", [45, 68, 74, 150, 154, 231])
def test_a_joint_stays_inside_its_limits_whatever_pauses(seed: int) -> None:
    """Those of `bench/effort_stalls.py` in whose like a joint had been up to four times as fast as allowed."""
    run = played(seed, per_s=8.0)
    assert run is not None
    assert run.speed <= 1.0
    assert run.position <= POSITION_LIMIT
    assert run.still
