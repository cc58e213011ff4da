"""Efforts from which a controller took something, of the bench's own joints: named or asked for, and truly bounded.

All of them failed before: what the controller adds is smooth and of another instant than the torque, its model of
gravity is a tenth off, and over a small range an offset hides what it left.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from effort_kinds import KEYS, effort_of
from plants import case_of, made
from recordings import recording_of

CAMPAIGN = pytest.mark.campaign


@pytest.mark.slow
@pytest.mark.parametrize(
    ("index", "kind", "sensors", "told", "named"),
    [
        (8, "friction_compensated", "motor+link", "friction_compensated", "effort_friction_compensated"),
        pytest.param(7, "gravity_nearly", "motor", "auto", "effort_kind_open", marks=CAMPAIGN),
        pytest.param(15, "gravity_nearly", "motor+link", "auto", "effort_gravity_compensated", marks=CAMPAIGN),
        pytest.param(1, "gravity_nearly", "motor+link", "auto", "effort_gravity_compensated", marks=CAMPAIGN),
        pytest.param(0, "friction_compensated", "motor+link", "auto", "effort_friction_compensated", marks=CAMPAIGN),
        pytest.param(16, "friction_compensated", "motor", "auto", "effort_friction_compensated", marks=CAMPAIGN),
    ],
)
def test_what_a_controller_took_is_told_and_in_the_intervals(
    index: int, kind: str, sensors: str, told: str, named: str
) -> None:
    case = case_of(3011, index)
    plant = made(case)
    recorded = replace(plant.recorded, motor_torque=effort_of(kind, case, plant))
    result = identify(recording_of(recorded, sensors), IdentifyOptions(sensors=sensors, effort_kind=told))
    assert named in {n.code for n in result.notices}
    for p in result.parameters:
        if p.key in KEYS and p.identifiable:
            assert abs(p.value - plant.truth[p.key]) < 3.5 * p.std, p
