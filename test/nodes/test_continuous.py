"""A joint that turns without end goes on where its reading wraps: measured on the plant."""

from __future__ import annotations

import math
import time
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import rig
from stand_in import exciting, stands

pytestmark = pytest.mark.ros


@pytest.mark.parametrize("kind", [pytest.param("velocity", marks=pytest.mark.campaign), "effort"])
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
