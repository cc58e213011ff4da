"""Fits that stalled, and joints that creep where friction holds them: recordings of `bench/plants` that were wrong."""

import sys
from dataclasses import replace
from pathlib import Path

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import pytest  # noqa: E402
from plants import case_of, made  # noqa: E402
from recordings import recording_of  # noqa: E402

from flex_ident.estimation.base_fit import base_fit, refined, rough_values, settled, without_creeping  # noqa: E402
from flex_ident.estimation.estimate import fit_problem, started_values  # noqa: E402
from flex_ident.likelihood.nuisances import measurement_priors  # noqa: E402
from flex_ident.parameters import FLEXIBLE_KEYS  # noqa: E402


@pytest.mark.campaign
def test_a_scale_of_the_link_encoder_does_not_stand_in_for_the_spring() -> None:
    case = made(case_of(131, 114))
    problem = fit_problem(recording_of(case.recorded, "motor+link"), sensors="motor+link")
    priors, start = measurement_priors(problem), started_values(problem, FLEXIBLE_KEYS)
    _, fit = base_fit(problem, FLEXIBLE_KEYS, start, priors)
    once = rough_values(problem, FLEXIBLE_KEYS, start, priors)
    _, stalled = refined(problem, FLEXIBLE_KEYS, settled(problem, once, priors), priors)
    assert abs(stalled.values["K"] / case.truth["K"] - 1.0) > 0.05  # else this recording shows nothing any more
    for key in ("Jm", "K", "JL"):
        assert abs(fit.values[key] / case.truth[key] - 1.0) < 0.005
    assert abs(fit.values["link_scale"]) < 2e-4 < 1e-3 < abs(stalled.values["link_scale"])


@pytest.mark.slow
def test_friction_that_lets_the_joint_creep_does_not_make_the_spring_softer() -> None:
    """Friction as a tanh of speed, a P-PI drive and a PRBS: long stretches in which the motor creeps and nothing moves.
    Taken for motion, they made K 0.2 % too small, 5.5 standard deviations."""
    case = made(case_of(131, 136))
    problem = fit_problem(recording_of(case.recorded, "motor"), sensors="motor")
    priors, start = measurement_priors(problem), started_values(problem, FLEXIBLE_KEYS)
    solver, fit = base_fit(problem, FLEXIBLE_KEYS, start, priors)
    assert 0.5 < solver.problem.usable.sum() / problem.usable.sum() < 0.95
    for key in ("K", "JL"):
        assert abs(fit.values[key] / case.truth[key] - 1.0) < 0.0008


@pytest.mark.slow
def test_what_turns_over_slowly_or_is_not_known_is_motion() -> None:
    """A reversal of many samples is seen for what it is, and a speed that the recording does not show leaves nothing
    out."""
    case = made(case_of(131, 136))
    problem = fit_problem(recording_of(case.recorded, "motor"), sensors="motor")
    priors, start = measurement_priors(problem), started_values(problem, FLEXIBLE_KEYS)
    values = rough_values(problem, FLEXIBLE_KEYS, start, priors)
    _, fit = refined(problem, FLEXIBLE_KEYS, settled(problem, values, priors), priors)
    assert without_creeping(problem, fit).resting_speed == pytest.approx(10.0 * fit.values["reversal_speed"])
    slow = replace(fit, values=fit.values | {"reversal_speed": 0.05})
    assert without_creeping(problem, slow) is problem
    nothing = replace(fit, jacobian=1e-6 * fit.jacobian)
    assert without_creeping(problem, nothing) is problem
