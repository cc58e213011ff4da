"""Every fault ends in a ramp down, a reason in one line, a readable bag, and commands inside the limits."""

from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from faults import FAULTS, inside_limits
from rig import rig

pytestmark = [pytest.mark.ros, pytest.mark.slow]


@pytest.mark.parametrize("name", FAULTS)
def test_fault(name: str, tmp_path: Path) -> None:
    play, reason = FAULTS[name]
    with rig(tmp_path) as made:
        found = play(made)
        assert inside_limits(found), found
        assert reason in found.reason, f"{found}\n{made.output('chirp_exciter')}"
        assert "Traceback" not in made.output("chirp_exciter")
        if name == "kill -9 of the exciter":
            assert found.status == -9
        else:
            assert found.status == 3, found
        if name not in ("start outside the limits", "no room on the disk", "start position not reached"):
            assert found.seconds > 1.5, found
