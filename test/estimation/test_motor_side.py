"""A spring on the motor, taken for one on the link: what is said of K and JL is what they would be."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flex_ident.estimation.motor_side import motor_side_notice
from flex_ident.notices import Notice
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import GRAVITY

JM, K, JL, SPRING = 0.1, 350.0, 1.0, 10.0
"""The joint as it is, its spring to ground on the motor."""
FREE = ("Jm", "K", "JL", "MY")


def _as_on_link() -> Values:
    """The joint with that spring on the link which is the same from the motor: K' K' / (K' + k) = K, k K' / (K' + k)
    the spring."""
    stiffness = K + SPRING
    slope = SPRING * stiffness / K
    return Values({"Jm": JM, "K": stiffness, "JL": JL * (stiffness / K) ** 2, "MY": slope / GRAVITY})


def _told(values: Values, *, std: float = 1e-3, unseen: float = 0.2, **problem: object) -> Notice | None:
    motion = SimpleNamespace(position=np.linspace(-0.05, 0.05, 101))
    of: Any = SimpleNamespace(**{"rigid": False, "link": None, "motion": motion, **problem})
    fit: Any = SimpleNamespace(values=values, free=FREE)
    known: Any = SimpleNamespace(std=lambda _key: std)
    return motor_side_notice(of, fit, known, {"MY": unseen * values["MY"]})


def test_both_joints_are_one_from_the_motor() -> None:
    s = 1j * np.linspace(0.5, 100.0, 200)
    own = _as_on_link()
    slope, k, jl = GRAVITY * own["MY"], own["K"], own["JL"]
    on_link = JM * s**2 + k * (jl * s**2 + slope) / (jl * s**2 + slope + k)
    on_motor = JM * s**2 + SPRING + K * JL * s**2 / (JL * s**2 + K)
    np.testing.assert_allclose(on_link, on_motor, rtol=1e-9)


def test_what_is_said_is_what_they_would_be() -> None:
    own = _as_on_link()
    notice = _told(own)
    assert notice is not None
    assert notice.numbers["moved_percent"] == pytest.approx(100.0 * (JL / own["JL"] - 1.0), rel=1e-3)
    assert notice.numbers["stiffness_percent"] == pytest.approx(100.0 * (K / own["K"] - 1.0), rel=1e-3)
    assert notice.numbers["moved_stds"] > 40.0


def test_nothing_is_said_within_the_interval_beside_a_link_encoder_or_of_gravity_that_shows() -> None:
    own = _as_on_link()
    assert _told(own, std=0.1) is None
    assert _told(own, link=np.zeros(101)) is None
    assert _told(own, rigid=True) is None
    assert _told(own, unseen=0.0) is None
    assert _told(own | {"MY": 0.01}) is None
