"""Weights: stretches in which the model leaves more than noise weigh as much less, the others as before."""

import numpy as np
import pytest

from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording

RATE, SECONDS = 500.0, 30
TRUTH = Values({"J": 2.0, "FV": 3.0, "FS": 0.0, "offset": 0.0})
WORSE = (12.0, 16.0)
"""Stretch in which something acts that the model has not, s."""


def rigid_problem(size: float = 0.0, *, drag: float = 0.0, noise: float = 0.3, friction: float = 0.0) -> FitProblem:
    """A rigid joint under a linear chirp; in the stretch `WORSE` alone a tone of `size`, N m, and more viscous friction
    by `drag` act."""
    t = np.arange(SECONDS * int(RATE)) / RATE
    phase, omega = 2 * np.pi * (0.2 * t + 0.1 * t**2), 2 * np.pi * (0.2 + 0.2 * t)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * (2 * np.pi * 0.2 * np.cos(phase) - omega**2 * np.sin(phase))
    torque = TRUTH["J"] * a + TRUTH["FV"] * v + friction * np.sign(v)
    torque += noise * np.random.default_rng(0).standard_normal(t.size)
    torque += (size * np.sin(2 * np.pi * 5.3 * t) + drag * v) * ((t > WORSE[0]) & (t < WORSE[1]))
    return FitProblem(Recording("j", RATE, q, torque), rigid=True, band_hz=10.0)


def power(solver: SteadyFit, *, inside: bool) -> float:
    """Mean power of the whitened residual at the truth within the worse stretch, or well away from it."""
    whitenings = solver.whitenings(TRUTH)
    residual = solver.whitened_residual(TRUTH, whitenings)
    time = solver.problem.time[solver.rows(whitenings)[0]]
    within = (time > WORSE[0] + 1.0) & (time < WORSE[1] - 1.0)
    away = (time < WORSE[0] - 2.0) | (time > WORSE[1] + 2.0)
    return float(np.mean(residual[within if inside else away] ** 2))


def test_noise_alone_is_whitened_to_one_with_and_without_local_weights() -> None:
    problem = rigid_problem()
    for local in (False, True):
        solver = SteadyFit(problem, local=local)
        assert power(solver, inside=False) == pytest.approx(1.0, abs=0.2)
        assert power(solver, inside=True) == pytest.approx(1.0, abs=0.5)


def test_a_stretch_that_is_worse_weighs_less_and_only_for_the_fit_to_estimate_with() -> None:
    problem = rigid_problem(1.0)
    searching, estimating = SteadyFit(problem), SteadyFit(problem, local=True)
    assert power(searching, inside=True) > 20.0
    assert power(estimating, inside=True) == pytest.approx(1.0, abs=0.3)
    assert power(estimating, inside=False) == pytest.approx(power(searching, inside=False), rel=0.1)


def test_jacobian_is_weighted_as_the_residual_is() -> None:
    solver = SteadyFit(rigid_problem(1.0), local=True)
    whitenings = solver.whitenings(TRUTH)
    there = TRUTH | {"J": TRUTH["J"] + 1e-3}
    change = solver.whitened_residual(there, whitenings) - solver.whitened_residual(TRUTH, whitenings)
    column = solver.whitened_jacobian(TRUTH, ("J",), whitenings)[:, 0]
    np.testing.assert_allclose(change / 1e-3, column, atol=1e-4 * float(np.max(np.abs(column))))


def test_a_worse_stretch_pulls_the_estimate_less() -> None:
    problem = rigid_problem(drag=0.5)
    moved = {}
    for local in (False, True):
        solver = SteadyFit(problem, local=local)
        fit = solver.solve(tuple(TRUTH), TRUTH, solver.whitenings(TRUTH), iterations=10)
        moved[local] = abs(fit.values["FV"] - TRUTH["FV"])
    assert moved[True] < 0.3 * moved[False], moved


def test_unknown_friction_at_standstill_is_told_from_the_rest() -> None:
    """Friction that does not turn over as Coulomb's does is taken for friction at standstill, if there is any."""
    problem = rigid_problem(friction=4.0)
    values = TRUTH | {"FS": 4.0}
    solver = SteadyFit(problem)
    whitening = solver.whitenings(values)[0]
    rest = problem.residuals(values)[0]
    held = solver.standstill_friction(rest, whitening)
    assert float(np.std(held)) < float(np.std(rest))
    assert not solver.standstill_friction(rest, solver.whitenings(values | {"FS": 0.0})[0]).any()
