"""A fit that stalls is tried again from another start: a recording of `bench/plants` in which it did."""

import sys
from pathlib import Path

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import pytest  # noqa: E402
from plants import case_of, made  # noqa: E402
from recordings import recording_of  # noqa: E402

from flex_ident.estimation.base_fit import base_fit, refined, rough_values, settled  # noqa: E402
from flex_ident.estimation.estimate import fit_problem, started_values  # noqa: E402
from flex_ident.likelihood.nuisances import measurement_priors  # noqa: E402
from flex_ident.parameters import FLEXIBLE_KEYS  # noqa: E402


@pytest.mark.slow
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
