"""What an encoder's rounding does to a fit, against the same recording of `bench/plants` without it."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from plants import case_of, made  # noqa: E402
from recordings import recording_of  # noqa: E402

from flex_ident.estimation.base_fit import refined, rough_values, settled  # noqa: E402
from flex_ident.estimation.encoder_rounding import rounding_bias  # noqa: E402
from flex_ident.estimation.estimate import fit_problem, started_values  # noqa: E402
from flex_ident.likelihood.fit import Fit  # noqa: E402
from flex_ident.likelihood.nuisances import measurement_priors  # noqa: E402
from flex_ident.likelihood.steady import SteadyFit  # noqa: E402
from flex_ident.parameters import FLEXIBLE_KEYS  # noqa: E402
from flex_ident.recording import Recording  # noqa: E402

COARSE = 1e-4
MAIN = ("Jm", "K", "JL")


def fitted(recording: Recording) -> tuple[SteadyFit, Fit]:
    """The fit of a motor alone, nothing taken off."""
    problem = fit_problem(recording, sensors="motor", band_hz=40.0)
    priors, start = measurement_priors(problem), started_values(problem, FLEXIBLE_KEYS)
    values = rough_values(problem, FLEXIBLE_KEYS, start, priors)
    return refined(problem, FLEXIBLE_KEYS, settled(problem, values, priors), priors)


@pytest.mark.campaign
def test_the_bias_of_a_coarse_encoder_is_no_larger_than_said() -> None:
    fine = recording_of(made(case_of(131, 101)).recorded, "motor")
    truth = fitted(fine)[1].values
    solver, fit = fitted(replace(fine, motor_position=np.round(fine.motor_position / COARSE) * COARSE))
    bias = rounding_bias(solver, fit)
    assert bias is not None
    for key in MAIN:
        assert abs(fit.values[key] - truth[key]) < 2.0 * abs(bias[fit.free.index(key)]) < 0.05 * truth[key]


@pytest.mark.campaign
def test_a_fine_encoder_has_hardly_any() -> None:
    solver, fit = fitted(recording_of(made(case_of(131, 24)).recorded, "motor"))
    bias = rounding_bias(solver, fit)
    for key in MAIN:
        assert bias is None or abs(bias[fit.free.index(key)]) < 1e-4 * fit.values[key]
