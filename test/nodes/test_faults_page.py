"""docs/faults.md has a row for each fault that a test plays, and no other; each says the cause that is asked for."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from faults import FAULTS, PAGE, with_rows
from situations import JOINT_FAULTS

KINDS = ("position", "velocity", "effort", "trajectory")


def cells() -> list[list[str]]:
    """The cells of each row of the two tables of what was measured."""
    rows = [line.strip("| ").split(" | ") for line in PAGE.read_text(encoding="utf-8").splitlines() if "|" in line]
    return [row for row in rows if len(row) > 3 and row[0] not in ("fault", "---")]


def test_each_fault_has_its_row_and_its_cause() -> None:
    commands = {row[0]: row[1] for row in cells() if row[1] not in KINDS}
    assert list(commands) == list(FAULTS)
    for name, fault in FAULTS.items():
        assert commands[name].startswith(f"{fault.status}: "), name
        assert fault.reason in commands[name], name


def test_each_fault_on_the_joints_has_its_row_and_its_cause() -> None:
    joints = {(row[0], row[1]): row[2] for row in cells() if row[1] in KINDS}
    assert list(joints) == [(name, kind) for name, fault in JOINT_FAULTS.items() for kind in fault.kinds]
    for (name, kind), said in joints.items():
        assert said.startswith(f"{JOINT_FAULTS[name].status}: "), (name, kind)
        assert JOINT_FAULTS[name].reason in said, (name, kind)


def test_a_row_takes_its_own_place() -> None:
    assert with_rows("| a | 1 |\n| b | 2 |\n", {"| b |": "| b | 3 |"}) == "| a | 1 |\n| b | 3 |\n"
    with pytest.raises(AssertionError, match="has 0 rows"):
        with_rows("| a | 1 |\n", {"| b |": "| b | 3 |"})
