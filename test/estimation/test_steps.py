"""Staircases and slow ramps: the motor rests most of the time, who of motor and link rubs is hard to tell, and a link
encoder sees little of the spring."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import plants.cases
import plants.experiment
from plants import Made, case_of, made
from recordings import recording_of

SECONDS = 20.0


def staircase(
    kind: str, t: NDArray[np.float64], duration_s: float, low: float, high: float, corner: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:  # fmt: skip
    """Random levels (n,) of -1 to 1, held for a second or so."""
    hold, wave, at = rng.uniform(0.6, 1.5), np.zeros(t.size), 0.5
    while at < duration_s - 0.5:
        wave[t >= at] = rng.uniform(-1.0, 1.0)
        at += hold
    return wave


def ramps(
    kind: str, t: NDArray[np.float64], duration_s: float, low: float, high: float, corner: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:  # fmt: skip
    """The same levels (n,), reached in half a second."""
    hold, wave, at, level = rng.uniform(0.6, 1.5), np.zeros(t.size), 0.5, 0.0
    while at < duration_s - 0.5:
        then, after = rng.uniform(-1.0, 1.0), t >= at
        wave[after] = level + (then - level) * np.clip((t[after] - at) / rng.uniform(0.25, 0.8), 0.0, 1.0)
        level = then
        at += hold
    return wave


def played(seed: int, index: int, excitation: object, monkeypatch: pytest.MonkeyPatch) -> Made:
    """A joint of the bench in such moves."""
    monkeypatch.setattr(plants.experiment, "excitation", excitation)
    monkeypatch.setattr(plants.cases, "DURATION_S", SECONDS)
    monkeypatch.setattr(plants.cases, "SHORT_S", SECONDS)
    return made(case_of(seed, index))


@pytest.mark.slow
@pytest.mark.parametrize("index", [0, pytest.param(14, marks=pytest.mark.campaign)])
def test_friction_of_motor_and_link_is_told_apart_in_steps(index: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """FS was 30 standard deviations off (torque commands, Coulomb friction), and 8 (impedance, tanh of the speed)."""
    plant = played(9001, index, staircase, monkeypatch)
    result = identify(recording_of(plant.recorded, "motor"), IdentifyOptions(sensors="motor"))
    assert result.verdict == "trusted"
    for key in ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS"):
        p = result.parameter(key)
        assert abs(p.value - plant.truth[key]) < 3.0 * p.std, p


@pytest.mark.slow
def test_a_link_encoder_that_leads_to_nothing_does_not_hide_the_rigid_joint(monkeypatch: pytest.MonkeyPatch) -> None:
    """Was rejected with all parameters not identifiable, and by the motor alone a rigid joint."""
    plant = played(9003, 1, ramps, monkeypatch)
    result = identify(recording_of(plant.recorded, "motor+link"), IdentifyOptions())
    assert (result.verdict, result.sensors) == ("doubtful", "motor")
    said = next(n for n in result.notices if n.code == "taken_as_rigid")
    assert said.case == "beside_link"
    inertia, whole = result.parameter("J"), plant.truth["Jm"] + plant.truth["JL"]
    assert abs(inertia.value - whole) < 3.0 * inertia.std
