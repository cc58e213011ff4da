"""A base from which no search can start is explained all the same."""

import importlib

import pytest
from named_cases import rigid_gravity

from flex_ident.errors import ExcitationError
from flex_ident.gap import GapOptions, explain


def test_a_base_whose_simulation_runs_away_under_other_weights_is_searched_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []

    def runs_away(*_given: object) -> object:
        asked.append(True)
        raise ExcitationError("the simulation runs away.")

    monkeypatch.setattr(importlib.import_module("flex_ident.gap.explain"), "search_start", runs_away)
    recording, truth = rigid_gravity(1)
    explanation = explain(recording, GapOptions(rigid=True, effects=("viscous_asymmetry", "hysteresis")))
    assert asked
    assert (explanation.verdict, explanation.findings) == ("complete", ())
    assert explanation.final.parameter("J").value == pytest.approx(truth["J"], rel=0.01)
