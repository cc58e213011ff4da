"""Friction that bends before it slides is named with its sizes, on the plants of `bench/plants`; none else is."""

from __future__ import annotations

import pytest
from named_cases import COBOT, HIDDEN, flexible_case

from flex_ident.estimation.estimate import fit_problem
from flex_ident.gap import GapOptions, explain
from flex_ident.gap.base import fitted_base

NUISANCES = {"presliding", "reversal_speed", "reversal_lead"}


@pytest.mark.campaign
def test_the_base_leaves_bristles_that_are_certain_to_the_search_and_keeps_the_nuisance_where_told() -> None:
    options = GapOptions(sensors="motor")
    problem = fit_problem(flexible_case("lugre")[0], sensors="motor")
    base = fitted_base(problem, options)
    assert [effect.name for effect in base.stood_for] == ["presliding_friction"]
    assert "presliding" not in base.kinds.fit.free
    kept = fitted_base(problem, GapOptions(sensors="motor", staying=("presliding_friction",)), base.whole)
    assert kept.stood_for == ()
    assert set(kept.kinds.fit.free) >= NUISANCES
    other = GapOptions(sensors="motor", effects=("backlash",))  # an effect that may not be sought is not left out
    assert fitted_base(problem, other).stood_for == ()


@pytest.mark.campaign
@pytest.mark.parametrize("case", ["plain", "stribeck"])
def test_dry_friction_that_turns_over_at_once_is_no_bristle(case: str) -> None:
    problem = fit_problem(flexible_case(case)[0], sensors="motor+link")
    assert fitted_base(problem, GapOptions()).stood_for == ()


@pytest.mark.slow
@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
@pytest.mark.campaign
def test_bristles_with_a_stribeck_curve_are_named_and_measured(sensors: str) -> None:
    truth = COBOT._replace(**HIDDEN["lugre"])
    found = explain(flexible_case("lugre")[0], GapOptions(sensors=sensors))
    assert [f.effect for f in found.findings] == ["presliding_friction"]
    assert found.verdict == "explained"
    told = {p.key: p for p in found.findings[0].parameters}
    at_rest = (truth.FSm + truth.stribeck) / truth.bristle
    for key, true in (("deflection", at_rest), ("amplitude", truth.stribeck), ("velocity", truth.stribeck_speed)):
        assert told[key].identifiable
        assert abs(told[key].value - true) < 3.0 * told[key].std, (told[key], true)
    for key in ("Jm", "K", "JL", "FSm"):
        p = found.final.parameter(key)
        assert abs(p.value - getattr(truth, key)) < 3.0 * p.std, p
    assert not NUISANCES & set(found.final.model.parameters)


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("sensors", ["motor+link", "motor"])
def test_friction_loss_of_mujoco_is_named_and_its_settings_are_found(sensors: str) -> None:
    truth = COBOT._replace(**HIDDEN["mujoco_friction"])
    found = explain(flexible_case("mujoco_friction")[0], GapOptions(sensors=sensors))
    assert [f.effect for f in found.findings] == ["presliding_friction"]
    assert found.verdict == "explained"
    softness, time = found.findings[0].parameters
    true = 1.0 / 0.9 - 1.0  # solimp 0.9 as it comes
    assert abs(softness.value - true) < max(0.03 * true, 2.0 * softness.std)
    assert time.value == pytest.approx(0.5 * 0.95 * 0.02, rel=0.03)  # solref 0.02, solimp 0.95
    for key in ("Jm", "K", "JL", "FSm", "FS"):
        p = found.final.parameter(key)
        assert abs(p.value - getattr(truth, key)) < 3.0 * p.std, p
