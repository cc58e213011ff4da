"""Staircases: the motor rests most of the time, and who of motor and link rubs is hard to tell."""

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
from plants import case_of, made
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


@pytest.mark.slow
@pytest.mark.parametrize("index", [0, pytest.param(14, marks=pytest.mark.campaign)])
def test_friction_of_motor_and_link_is_told_apart_in_steps(index: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """FS was 30 standard deviations off (torque commands, Coulomb friction), and 8 (impedance, tanh of the speed)."""
    monkeypatch.setattr(plants.experiment, "excitation", staircase)
    monkeypatch.setattr(plants.cases, "DURATION_S", SECONDS)
    monkeypatch.setattr(plants.cases, "SHORT_S", SECONDS)
    plant = made(case_of(9001, index))
    result = identify(recording_of(plant.recorded, "motor"), IdentifyOptions(sensors="motor"))
    assert result.verdict == "trusted"
    for key in ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS"):
        p = result.parameter(key)
        assert abs(p.value - plant.truth[key]) < 3.0 * p.std, p
