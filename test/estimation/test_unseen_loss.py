"""A spring that loses a hundredth, or relaxes by as little, damps the mode as friction does: the intervals hold it."""

import pytest
from geared_arm import TRUTH, recorded_arm

from flex_ident.effects import CATALOGUE
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.estimation.unseen_effects import loss_error, loss_notices
from flex_ident.parameters.values import Values


def test_what_moves_friction_by_less_than_a_tenth_is_left_out() -> None:
    assert loss_error("FV", 4.0, {"FV": 0.39}) == 0.0
    assert loss_error("FV", 4.0, {"FV": 0.5}) == 0.5
    assert loss_error("FVm", 4.0, {}) == 0.0
    assert loss_error("K", 4.0, {"K": 3.0}) == 0.0


def test_it_is_said_of_each_friction_that_it_moves() -> None:
    said = list(loss_notices({"FV": 2.0, "FVm": 0.1}, Values({"FV": 4.0, "FVm": 12.0})))
    assert [(n.code, n.subject, n.numbers) for n in said] == [("loss_unseen", "FV", {"moved_percent": 50.0})]


@pytest.mark.parametrize("name", ["joint_damping", "viscoelastic_spring"])
def test_a_loss_in_the_model_is_not_beside_it_again(name: str) -> None:
    unseen = CATALOGUE[name].unseen
    assert unseen is not None
    spring = Values({"K": 2e4, "JL": 4.0})
    assert unseen(spring)
    first = CATALOGUE[name].parameters[0].name
    assert not unseen(spring | Values.of_effect(name, {first: 1.0}))
    assert not unseen(Values({"J": 4.0}))


@pytest.mark.slow
@pytest.mark.parametrize(
    "spring", [{}, {"damping": 3.0}, pytest.param({"relaxing": 400.0}, marks=pytest.mark.campaign)]
)
def test_friction_beside_a_loss_that_does_not_show(spring: dict[str, float]) -> None:
    result = identify(recorded_arm(**spring), IdentifyOptions())
    for p in result.parameters:
        if p.key != "offset":
            assert abs(p.value - TRUTH[p.key]) < 3.0 * p.std, p
    assert "loss_unseen" in {n.code for n in result.notices}
