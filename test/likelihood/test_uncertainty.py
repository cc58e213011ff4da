"""How uncertain an optimum is: friction at its bound."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import linear_fit, white

from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.parameters.values import Values

ALIKE = 0.999
"""How alike the frictions of motor and link act in a motion that never comes near the mode."""


def fit_of(names: tuple[str, str], at_bound: tuple[str, ...]) -> Fit:
    """Two columns that are nearly one, fitted to their sum in noise."""
    one = white(1, 2000)
    two = ALIKE * one + np.sqrt(1.0 - ALIKE**2) * white(2, 2000)
    fit = linear_fit(np.column_stack((one, two)), 0.08 * one + white(3, 2000))
    return replace(fit, free=names, values=Values().with_vector(names, (0.0, 0.08)), at_bound=at_bound)


def test_friction_beside_one_that_is_nothing_is_as_open_as_that() -> None:
    free = uncertainty_of(fit_of(("FVm", "FV"), ()), 100.0)
    bound = uncertainty_of(fit_of(("FVm", "FV"), ("FVm",)), 100.0)
    assert bound.std("FV") == pytest.approx(free.std("FV"))
    assert bound.std("FVm") == pytest.approx(free.std("FVm"))


def test_what_is_beside_another_key_at_its_bound_is_known_as_without_it() -> None:
    bound = uncertainty_of(fit_of(("effort_lag", "FV"), ("effort_lag",)), 100.0)
    free = uncertainty_of(fit_of(("effort_lag", "FV"), ()), 100.0)
    assert bound.std("FV") < 0.1 * free.std("FV")
    assert bound.std("effort_lag") > 0.5 * free.std("effort_lag")
