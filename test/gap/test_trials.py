"""What speaks against a candidate, and a refit that is caught where what was missing had drawn its nuisances."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from flex_ident.effects import effect_named
from flex_ident.gap.objections import within_own_error, within_rounding
from flex_ident.gap.thresholds import OWN_ERROR
from flex_ident.gap.trials import unstuck
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.thresholds import OWN_ERROR_OF_LINK
from flex_ident.parameters.prior import Prior
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats


def fit_at(values: Values, residual: Floats, free: tuple[str, ...] = ()) -> Fit:
    """A fit with these values and this whitened residual, and nothing else."""
    nothing = np.zeros((residual.size, len(free)))
    return Fit(free, values, nothing, residual, (), np.zeros((len(free), len(free))), (), (), 0.5 * residual @ residual)


@pytest.mark.parametrize(
    ("changes", "little"),
    [
        ({"torque": 0.5 * OWN_ERROR}, True),
        ({"torque": 2.0 * OWN_ERROR}, False),
        ({"torque": 0.5 * OWN_ERROR, "deflection": 0.5 * OWN_ERROR_OF_LINK}, True),
        ({"torque": 0.0, "deflection": 2.0 * OWN_ERROR_OF_LINK}, False),
    ],
)
def test_what_changes_less_than_the_method_may_be_wrong_by_is_no_cause(changes: dict[str, float], little: bool) -> None:
    """However certain: two clean joints with fine link encoders had a name for 0.13 % of the deflection."""
    assert (within_own_error(changes, OWN_ERROR) is not None) == little


def test_a_periodic_error_within_its_encoders_rounding_is_none() -> None:
    """A direct drive without any was given one of a tenth of a step (`bench/coverage.py --explain`, seed 361)."""
    step = 2.0 * np.pi / 2**17
    assert within_rounding(0.4 * step, step / np.sqrt(12.0)) is not None
    assert within_rounding(0.5 * step, step / np.sqrt(12.0)) is None
    assert within_rounding(0.0, step) is None


def test_a_limit_at_the_level_at_which_the_torque_rests_takes_off_its_noise() -> None:
    """A controller that switched between two torques was given a limit at the larger (`bench/coverage.py --explain`,
    seed 401)."""
    of_noise = effect_named("saturation").of_noise
    assert of_noise is not None
    resting = 37.0 + 0.5 * np.random.default_rng(1).standard_normal(4000)
    assert of_noise({"limit": 37.0}, resting, 0.5) is not None
    assert of_noise({"limit": 50.0}, resting, 0.5) is not None
    clipped = 37.0 * np.sin(np.arange(4000) / 20.0)
    assert of_noise({"limit": 0.9 * 37.0}, clipped, 0.5) is None


@dataclass
class TwoMinima:
    """A fit of one parameter and a delay, with one minimum at no delay, and a worse one at `caught`."""

    caught: float = -1.0
    priors: Any = None

    def __post_init__(self) -> None:
        self.priors = {"torque_delay": Prior(0.0, 10.0, -2.0, 2.0)}

    def whitenings(self, values: Values) -> tuple[()]:
        """Nothing to whiten with."""
        return ()

    def whitened_residual(self, values: Values, whitenings: tuple[()]) -> Floats:
        """Fifty samples, and more at the worse minimum."""
        delay = values["torque_delay"]
        here = min(abs(delay), abs(delay - self.caught) + 0.1)
        return np.full(50, 10.0 * here)

    def solve(self, keys: tuple[str, ...], start: Values, whitenings: tuple[()], **_rest: object) -> Fit:
        """The nearer of the two."""
        near = 0.0 if abs(start["torque_delay"]) < abs(start["torque_delay"] - self.caught) else self.caught
        values = start | {"torque_delay": near}
        return fit_at(values, self.whitened_residual(values, ()), keys)


def test_nuisances_that_are_caught_are_put_back() -> None:
    solver: Any = TwoMinima()
    free, start = ("K", "effort_lag", "torque_delay"), Values({"K": 1.0, "effort_lag": 0.0, "torque_delay": -0.9})
    solver.priors["effort_lag"] = solver.priors["torque_delay"]
    fit = solver.solve(free, start, ())
    assert fit.values["torque_delay"] == -1.0
    assert unstuck(solver, fit) is fit  # a delay is what any model finds: it is not put back
    caught = replace(fit, values=fit.values | {"torque_delay": -0.4})
    assert unstuck(solver, caught).values["torque_delay"] == 0.0
    assert unstuck(solver, unstuck(solver, caught)).values["torque_delay"] == 0.0
