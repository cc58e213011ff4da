"""What a recording can answer: the three commands say the same, of a slow one and of one that crosses the mode."""

import json
from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags.selection import SignalSelection
from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.bags.writing import write_joint_states
from flex_ident.commands.check_bag import bag_check
from flex_ident.commands.explain_gap import main as explain_gap
from flex_ident.commands.identify_bag import main as identify_bag
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import Experiment


def slow_bag(path: Path) -> Path:
    """Slow sines of a rigid joint with friction and weight: inverse dynamics, noise, an encoder's steps."""
    random = np.random.default_rng(5)
    time = np.arange(0.0, 30.0, 8e-3)
    w = 2.0 * np.pi * np.array([0.11, 0.31])[:, None]
    size = np.array([0.8, 0.2])[:, None]
    position, speed = (size * np.sin(w * time)).sum(axis=0), (size * w * np.cos(w * time)).sum(axis=0)
    acceleration = -(size * w**2 * np.sin(w * time)).sum(axis=0)
    torque = 1.5 * acceleration + 4.0 * speed + 6.0 * np.sign(speed) + 20.0 * np.sin(position)
    torque = torque + 0.3 * random.standard_normal(time.size)
    position = np.floor(position / 1e-5) * 1e-5
    none = np.zeros((time.size, 0))
    write_joint_states(path, time, ["joint"], position[:, None], none, torque[:, None])
    return path


def lively_bag(path: Path) -> Path:
    truth = {"Jm": 1.2, "K": 9000.0, "JL": 2.5, "FVm": 8.0, "FSm": 6.0, "FV": 4.0, "FS": 3.0}
    write_virtual_bag(
        path, JointModel(truth, {}, "joint"), Experiment(duration_s=24.0, sample_rate_hz=500.0), seed=3, link=False
    )
    return path


@pytest.mark.slow
@pytest.mark.parametrize("model", ["rigid", pytest.param("spring", marks=pytest.mark.campaign)])
def test_the_three_commands_agree(model: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = slow_bag(tmp_path / "bag") if model == "rigid" else lively_bag(tmp_path / "bag")
    text, error = bag_check(bag, SignalSelection(joint="joint"))
    assert error is None
    line = next(s.strip() for s in text.splitlines() if "this recording answers" in s)
    assert ("no spring shows" in line) == (model == "rigid")
    assert "no other joint moved" in line
    for command in (identify_bag, explain_gap):
        capsys.readouterr()
        command([str(bag), "--joint", "joint", "--json", "--no-plots", "--out", str(tmp_path / command.__module__)])
        told = json.loads(capsys.readouterr().out)
        assert told["answers"]["model"] == model, command.__module__
        assert told["answers"]["other_joints"] == []
    assert ("friction_curve" in json.loads((tmp_path / identify_bag.__module__ / "result.json").read_text())) == (
        model == "rigid"
    )
