"""Harmonics are numbered alike over recordings, and angles lie together."""

import math
from dataclasses import replace

import numpy as np
import pytest

from flex_ident.gap.alike import aligned
from flex_ident.parameters import Covariance, Identification, JointModel, Parameter
from flex_ident.parameters.identification import FitQuality

UNITS = {"amplitude": "N m", "cycles_per_turn": "1", "phase": "rad"}


def found(*harmonics: tuple[float, float, float]) -> Identification:
    parameters = tuple(
        Parameter(f"torque_ripple.{name}{'' if i == 0 else f'_{i + 1}'}", value, 0.1, UNITS[name])
        for i, own in enumerate(harmonics) for name, value in zip(UNITS, own, strict=True)
    )  # fmt: skip
    count = len(parameters)
    covariance = Covariance(tuple(p.key for p in parameters), np.diag(np.arange(1.0, count + 1)), np.zeros(count))
    return Identification(
        "j", "motor", "explain_gap", "trusted", parameters, FitQuality(1, 1.0, 1, 0.0, 0.0), JointModel({"J": 1.0}, {}),
        covariance=covariance,
    )  # fmt: skip


def test_harmonics_of_other_order_get_the_numbers_of_the_first() -> None:
    one, two = aligned([found((2.0, 40.0, 0.1), (1.0, 80.0, 0.2)), found((1.1, 80.1, 0.3), (1.9, 40.1, 0.1))])
    assert one == replace(one, parameters=found((2.0, 40.0, 0.1), (1.0, 80.0, 0.2)).parameters)
    assert two.parameter("torque_ripple.cycles_per_turn").value == 40.1
    assert two.parameter("torque_ripple.amplitude_2").value == 1.1
    assert two.covariance is not None
    assert two.covariance.of(["torque_ripple.amplitude"])[0, 0] == 4.0


def test_another_period_is_another_harmonic() -> None:
    _, two = aligned([found((2.0, 40.0, 0.1)), found((1.0, 60.0, 0.1))])
    assert [p.key for p in two.parameters if "cycles" in p.key] == ["torque_ripple.cycles_per_turn_2"]


def test_angles_are_turned_towards_the_first() -> None:
    _, two = aligned([found((2.0, 40.0, 3.1)), found((2.0, 40.0, -3.1))])
    assert two.parameter("torque_ripple.phase").value == pytest.approx(2.0 * math.pi - 3.1)
