"""Values keep their order, never change, and are equal and hash by their content."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from flex_ident.parameters.values import Values

GIVEN = {"backlash.gap": 1e-3, "K": 2.0, "hysteresis.torque": 1.0, "link_skew": 0.1, "hysteresis.deflection": 0.2}


def test_values_are_read_like_a_mapping_in_the_order_given() -> None:
    values = Values(GIVEN)
    assert list(values) == list(GIVEN)
    assert list(values.items()) == list(GIVEN.items())
    assert (len(values), values["K"], values.get("JL", 7.0), "K" in values, "JL" in values) == (
        5,
        2.0,
        7.0,
        True,
        False,
    )
    with pytest.raises(KeyError):
        values["JL"]
    assert not Values()
    assert repr(Values({"K": 2.0})) == "Values({'K': 2.0})"


def test_nothing_changes_values() -> None:
    own = dict(GIVEN)
    values = Values(own)
    own["K"] = 3.0
    assert values == GIVEN
    with pytest.raises(TypeError):
        values["K"] = 3.0  # type: ignore[index]
    with pytest.raises(TypeError):
        del values["K"]  # type: ignore[attr-defined]
    with pytest.raises(AttributeError):
        values.K = 3.0  # type: ignore[attr-defined]
    with pytest.raises(TypeError):
        values.effects["backlash"] = {}  # type: ignore[index]
    with pytest.raises(TypeError):
        values.effects["backlash"]["gap"] = 0.0  # type: ignore[index]


def test_equal_values_are_one_key_in_whatever_order() -> None:
    values, turned = Values(GIVEN), Values(dict(reversed(GIVEN.items())))
    assert values == turned == GIVEN
    assert hash(values) == hash(turned)
    assert {values: "remembered"}[turned] == "remembered"
    assert values != Values({**GIVEN, "K": math.nextafter(2.0, 3.0)})
    assert values != Values({k: v for k, v in GIVEN.items() if k != "K"})
    assert values != tuple(GIVEN)


def test_values_go_to_another_process() -> None:
    values = Values(GIVEN)
    hash(values), values.effects
    again = pickle.loads(pickle.dumps(values))
    assert again == values
    assert list(again) == list(values)
    assert again._hash is None  # strings hash otherwise there


def test_what_is_replaced_stays_in_its_place_and_what_is_new_comes_last() -> None:
    values = Values({"K": 2.0, "JL": 1.0})
    moved = values | {"FV": 0.5, "K": 3.0}
    assert list(moved.items()) == [("K", 3.0), ("JL", 1.0), ("FV", 0.5)]
    assert moved == values | Values({"FV": 0.5, "K": 3.0})
    assert values == {"K": 2.0, "JL": 1.0}
    moved = values
    moved |= {"K": 4.0}
    assert values["K"] == 2.0


def test_some_keys_are_taken_or_left_in_the_order_of_the_values() -> None:
    values = Values(GIVEN)
    assert list(values.only(("link_skew", "K", "JL"))) == ["K", "link_skew"]
    assert list(values.without(("K", "JL", "backlash.gap"))) == [
        "hysteresis.torque",
        "link_skew",
        "hysteresis.deflection",
    ]


def test_a_vector_has_zero_for_what_is_not_there() -> None:
    values = Values({"K": 2.0, "JL": 1.0})
    assert values.vector(("JL", "FV", "K")).tolist() == [1.0, 0.0, 2.0]
    assert values.vector(()).size == 0
    moved = values.with_vector(("FV", "K"), np.array([0.5, 3.0]))
    assert list(moved.items()) == [("K", 3.0), ("JL", 1.0), ("FV", 0.5)]
    assert all(type(value) is float for value in moved.values())
    with pytest.raises(ValueError, match="shorter"):
        values.with_vector(("FV", "K"), np.array([0.5]))


def test_values_come_apart_and_together_again() -> None:
    values = Values(GIVEN)
    assert values.base == {"K": 2.0, "link_skew": 0.1}
    assert values.effects == {"backlash": {"gap": 1e-3}, "hysteresis": {"torque": 1.0, "deflection": 0.2}}
    again = values.base
    for effect, parameters in values.effects.items():
        again |= Values.of_effect(effect, parameters)
    assert again == values
    assert not Values({"K": 2.0}).effects
