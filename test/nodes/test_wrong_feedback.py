"""Feedback that is known to be wrong moves nothing: measured on the plant, under effort and velocity commands."""

from __future__ import annotations

import math
import time
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
import numpy as np
from rig import rig
from stand_in import exciting, stands

pytestmark = pytest.mark.ros
REASONS = {
    "wrap": "a whole turn: it wraps", "jump": "jumps by +0.3", "freeze": "frozen", "nan": "is nan",
    "lose_joint": "vanished",
}  # fmt: skip


@pytest.mark.parametrize("kind", ["velocity", "effort"])
@pytest.mark.parametrize("fault", REASONS)
def test_the_joint_comes_to_rest_blind(kind: str, fault: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        exciting(made, kind, **{"limits.state_timeout_s": 0.25})
        at = time.monotonic()
        made.set_parameter("robot", "fault", fault)
        assert made.ended("chirp_exciter") == 3
        assert REASONS[fault] in made.output("chirp_exciter"), made.output("chirp_exciter")
        made.spin(1.0)
        after = stands(made, at)
    if kind == "effort":
        # 300 N m/rad on a jump of 0.3 rad would be 90 N m, on a whole turn 1900: the limit is 60.
        assert np.abs(after[:, 6]).max() < 30.0
        assert after[-1, 6] == pytest.approx(2.0, abs=0.5)


@pytest.mark.parametrize("kind", ["velocity", "effort"])
def test_a_joint_without_end_is_excited_across_the_wrap_of_its_reading(kind: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        start = math.pi - 0.02
        exciting(
            made, kind, robot={"kind": "continuous", "wraps": True, "positions": [0.5, start]},
            **{"limits.position_min": start - 0.4, "limits.position_max": start + 0.4, "chirp.duration_s": 3.0},
        )  # fmt: skip
        at = time.monotonic()
        assert made.ended("chirp_exciter") == 0, made.output("chirp_exciter")
        made.spin(0.3)
        stands(made, at, start=start)
        assert made.truth()[:, 2].max() > math.pi + 0.01
