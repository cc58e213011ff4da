"""Every fault leaves the robot's joints inside their limits and at rest, whatever commands them; and is told truly."""

from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from plant_faults import played
from rig import rig
from situations import JOINT_FAULTS

pytestmark = [pytest.mark.ros, pytest.mark.slow]
QUICK = {
    ("kill -9 of the exciter", "effort"),
    ("the exciter stands still (SIGSTOP) and goes on", "effort"),
    ("the readings that an effort is closed over thin out to 10 Hz", "effort"),
    ("the readings that a loop is closed over are 0.55 s old, 0.6 s allowed", "effort"),
    ("a simulator at half of real time", "velocity"),
}
"""What is played each time: an effort that stands, or that is closed over bad readings, is the most dangerous of all
commands."""
CASES = [
    pytest.param(name, kind, marks=[] if (name, kind) in QUICK else [pytest.mark.campaign])
    for name, fault in JOINT_FAULTS.items()
    for kind in fault.kinds
]


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_the_joints_stay_inside_their_limits_and_come_to_rest(name: str, kind: str, tmp_path: Path) -> None:
    fault = JOINT_FAULTS[name]
    with rig(tmp_path) as made:
        found = played(made, fault, kind)
        said = made.output("chirp_exciter")
    assert fault.broken(found) == "", f"{found}\n{said}"
    assert "Traceback" not in said
