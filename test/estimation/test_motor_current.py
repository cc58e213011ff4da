"""A torque sensor behind the gear and the motor current beside it give all nine parameters and the torque constant."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from kinds_of_effort import kind_recording

from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.bags.writing import write_joint_states
from flex_ident.errors import UsageError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import Identification, JointModel
from flex_ident.recording import Recording
from flex_ident.report.sentences import sentence
from flex_ident.virtual_joint import Experiment

TRUTH = {
    "Jm": 1.5, "K": 12000.0, "JL": 2.2, "FVm": 12.0, "FSm": 6.0, "FV": 3.0, "FS": 1.0, "MX": 0.0, "MY": -8.0,
}  # fmt: skip
CONSTANT = 11.0
"""N m on the link side per ampere."""
EXPERIMENT = Experiment(duration_s=30.0, start_frequency_hz=0.1, end_frequency_hz=30.0, amplitude=0.1)


@cache
def both_recorded(seed: int = 1) -> Recording:
    model = JointModel(TRUTH, {}, "joint")
    sensed = kind_recording(model, "joint_sensor", EXPERIMENT, bits=19, link=False, seed=seed)
    driven = kind_recording(model, "motor", EXPERIMENT, bits=19, link=False, seed=seed)
    return replace(sensed, motor_current=driven.motor_torque / CONSTANT)


@cache
def identified(seed: int) -> Identification:
    return identify(both_recorded(seed))


@pytest.mark.campaign
def test_a_current_that_is_late_moves_nothing() -> None:
    plain, recording = identified(1), both_recorded(1)
    assert recording.motor_current is not None
    late = round(0.004 * recording.sample_rate_hz)
    late_current = np.concatenate((np.full(late, recording.motor_current[0]), recording.motor_current[:-late]))
    result = identify(replace(recording, motor_current=late_current))
    for key in ("Jm", "FVm", "FSm"):
        p = result.parameter(key)
        assert abs(p.value - TRUTH[key]) < 3.0 * p.std, (key, p)
        assert p.value == pytest.approx(plain.parameter(key).value, rel=0.005)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.campaign)])
def test_all_nine_and_the_torque_constant_are_found(seed: int) -> None:
    result = identified(seed)
    assert result.verdict != "rejected"
    for key in ("Jm", "FVm", "FSm", "K", "JL"):
        p = result.parameter(key)
        assert p.identifiable, key
        assert abs(p.value - TRUTH[key]) < 3.5 * p.std + 1e-4 * TRUTH[key], (key, p)
        assert p.std < 0.05 * TRUTH[key], key
    constant = next(p for p in result.measurement if p.key == "torque_constant")
    assert constant.unit == "N m/A"
    assert abs(constant.value - CONSTANT) < 3.5 * constant.std
    assert constant.std < 0.02 * CONSTANT
    said = next(n for n in result.notices if n.code == "motor_current")
    assert "torque constant of 1" in sentence(said)
    assert said.severity == "info"
    assert all(n.code != "effort_joint_sensor" for n in result.notices)
    assert result.model.value("Jm") == result.parameter("Jm").value


@pytest.mark.slow
def test_the_current_of_another_motor_is_not_trusted() -> None:
    recording = both_recorded(1)
    other = np.sin(7.0 * recording.time) + 0.1 * np.random.default_rng(0).standard_normal(recording.time.size)
    result = identify(replace(recording, motor_current=other))
    assert result.verdict != "trusted"
    said = next(n for n in result.notices if n.code == "motor_current")
    assert said.case == "poor"
    assert not result.parameter("Jm").identifiable or result.parameter("Jm").std > 0.0


def test_a_current_beside_another_kind_of_effort_is_refused() -> None:
    with pytest.raises(UsageError, match="--motor-current goes with --effort-kind joint_sensor"):
        identify(both_recorded(1), IdentifyOptions(effort_kind="gravity_compensated"))


def test_the_current_is_read_from_its_topic(tmp_path: Path) -> None:
    recording = both_recorded(1)
    assert recording.motor_current is not None
    none = np.zeros((recording.time.size, 0))
    position, effort = recording.motor_position[:, None], recording.motor_torque[:, None]
    more = {"/drives": (recording.time, ["joint"], recording.motor_current[:, None])}
    bag = tmp_path / "bag"
    write_joint_states(bag, recording.time, ["joint"], position, none, effort, more=more)
    read = read_recording(bag, SignalSelection(motor_current="/drives:joint.position"))
    assert read.motor_current is not None
    np.testing.assert_allclose(read.motor_current, recording.motor_current, atol=1e-9)
    assert read_recording(bag).motor_current is None
