"""A spring that loses a hundredth, or relaxes by as little, damps the mode as friction does: the intervals hold it."""

import pytest
from geared_arm import TRUTH, recorded_arm

from flex_ident.effects import CATALOGUE
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.estimation.unseen_effects import loss_error, loss_notices
from flex_ident.parameters.values import Values


def test_what_moves_friction_by_less_than_a_tenth_is_left_out() -> None:
    values = Values({"FV": 4.0, "FVm": 12.0, "Jm": 1.0, "K": 1e4})
    assert loss_error("FV", values, {"FV": 0.39, "FVm": 0.4}) == 0.0
    assert loss_error("FV", values, {"FV": 0.5, "FVm": 0.4}) == 0.5
    assert loss_error("FVm", values, {}) == 0.0
    assert loss_error("K", values, {"FV": 0.5, "K": 3.0}) == 0.0


def test_where_one_friction_gains_the_other_and_the_inertia_are_open_as_well() -> None:
    values = Values({"FV": 0.16, "FVm": 1.17, "Jm": 0.2})
    lossy = {"FV": 0.0588, "FVm": 0.0558, "Jm": 4.5e-4}
    assert [loss_error(key, values, lossy) for key in ("FV", "FVm", "Jm")] == [0.0588, 0.0558, 4.5e-4]
    assert [n.subject for n in loss_notices(lossy, values)] == ["FV"]


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


@pytest.mark.campaign
@pytest.mark.parametrize("spring", [{}, {"damping": 3.0}, {"relaxing": 400.0}])
def test_friction_beside_a_loss_that_does_not_show(spring: dict[str, float]) -> None:
    result = identify(recorded_arm(**spring), IdentifyOptions())
    for p in result.parameters:
        if p.key != "offset":
            assert abs(p.value - TRUTH[p.key]) < 3.0 * p.std, p
    assert "loss_unseen" in {n.code for n in result.notices}
