"""Every fault ends in a ramp down, a reason in one line, a readable bag, and commands inside the limits."""

from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from faults import FAULTS
from rig import rig

pytestmark = [pytest.mark.ros, pytest.mark.slow]


CASES = [pytest.param(name, marks=[pytest.mark.campaign] if fault.campaign else []) for name, fault in FAULTS.items()]


@pytest.mark.parametrize("name", CASES)
def test_fault(name: str, tmp_path: Path) -> None:
    fault = FAULTS[name]
    with rig(tmp_path) as made:
        found = fault.play(made)
        said = made.output("chirp_exciter")
    assert found.inside_limits, found
    assert fault.reason in found.reason, f"{found}\n{said}"
    assert found.status == fault.status, f"{found}\n{said}"
    assert "Traceback" not in said
    if fault.recorded:
        assert found.lost_s is not None
        # Joint states may end with the fault, references go on until the joint stands: what came before is in the bag.
        assert found.lost_s < 0.5 + (found.seconds_to_stop or 0.5), found
    elif fault.recorded is False:
        assert found.lost_s is None, found
        assert found.largest == 0.0, "something was commanded"
    if found.seconds_to_stop is not None:
        assert found.seconds_to_stop < 3.0, found
