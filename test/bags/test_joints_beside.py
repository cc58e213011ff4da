"""The bag's other joints: those that move are carried along and named, those that are held or shake are not."""

from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags import writing
from flex_ident.bags.motions import joint_motions
from flex_ident.bags.other_joints import tracks
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.commands.check_bag import bag_check
from flex_ident.errors import ExcitationError
from flex_ident.jobs.joints import moving_joints
from flex_ident.recording import Signal
from flex_ident.recording.clocks import RawSignal

RATE_HZ = 200.0


def arm(path: Path, *, seed: int = 1) -> Path:
    """`a` follows a sweep, `b` swings, `c` is held with noise of some counts, `d` shakes a little, `a_link` follows."""
    t = np.arange(0.0, 20.0, 1.0 / RATE_HZ)
    rng = np.random.default_rng(seed)
    a = 0.3 * np.sin(2.0 * np.pi * (0.2 * t + 0.1 * t**2))
    columns = {
        "a": a, "b": 0.5 * np.cos(t), "c": 0.7 + 1e-5 * rng.integers(-4, 5, t.size), "d": 0.1 + 1e-3 * np.sin(9.0 * t),
        "a_link": a + 1e-4 * np.cos(3.0 * t),
    }  # fmt: skip
    positions = np.stack(list(columns.values()), axis=1)
    efforts = 5.0 * np.gradient(positions, axis=0) * RATE_HZ + rng.standard_normal(positions.shape)
    writing.write_joint_states(path, t, list(columns), positions, np.zeros_like(positions), efforts)
    return path


def test_joints_that_move_are_carried_and_named(tmp_path: Path) -> None:
    recording = read_recording(arm(tmp_path / "bag"), SignalSelection(joint="a"))
    assert set(recording.others) == {"b"}
    assert recording.others["b"].size == recording.time.size
    assert np.max(np.abs(recording.others["b"] - 0.5 * np.cos(recording.time))) < 1e-3
    notice = next(n for n in recording.notices if n.code == "other_joints_move")
    assert (notice.numbers["count"], notice.texts["joints"]) == (1.0, "b")


@pytest.mark.slow
def test_check_bag_says_which_joints_moved(tmp_path: Path) -> None:
    text, _ = bag_check(arm(tmp_path / "bag"), SignalSelection(joint="a"))
    assert "1 other joint moved: b." in text
    held = next(line for line in text.splitlines() if line.split()[:2] == ["/joint_states", "c"])
    assert "held" in held


def test_a_joint_that_is_held_is_refused_by_every_reader(tmp_path: Path) -> None:
    bag = arm(tmp_path / "bag")
    with pytest.raises(ExcitationError, match="joint c does not move"):
        read_recording(bag, SignalSelection(joint="c"))
    text, error = bag_check(bag, SignalSelection(joint="c"))
    assert "joint c does not move" in text
    assert isinstance(error, ExcitationError)
    assert moving_joints(bag) == ["a", "b", "d"]
    assert {m.name for m in joint_motions(bag) if not m.moves} == {"c"}


def test_an_arm_that_is_held_has_no_joint_that_moves(tmp_path: Path) -> None:
    t = np.arange(0.0, 20.0, 1.0 / RATE_HZ)
    noise = np.random.default_rng(2).integers(-3, 4, (t.size, 3)) * 1e-5
    writing.write_joint_states(tmp_path / "bag", t, ["x", "y", "z"], noise, 0.0 * noise, 4.0 + noise)
    with pytest.raises(ExcitationError, match="no joint moved"):
        read_recording(tmp_path / "bag")


@pytest.mark.parametrize("broken", ["stamps", "values", "size", "order"])
def test_a_joint_beside_whose_messages_are_damaged_is_left_out(broken: str) -> None:
    seconds = 0.005 * np.arange(2000)
    values, stamps = np.sin(seconds), (1e9 * (1.0 + seconds)).astype(np.int64)
    if broken == "stamps":
        stamps = np.zeros_like(stamps)
    elif broken == "values":
        values = np.full_like(values, np.nan)
    elif broken == "size":
        values[::2] = 1e308 * np.sign(values[::2])
        values[1::2] = np.inf
    else:
        stamps = stamps[::-1].copy()
    motor = Signal("motor_position", "/joint_states:a.position", "header", seconds, np.sin(seconds))
    assert tracks({"b": RawSignal("/joint_states:b.position", stamps, stamps, values)}, motor, 1.0) == {}
