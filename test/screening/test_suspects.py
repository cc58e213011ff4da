"""What a missing effect would move: the linear shift is that of a refit, and intervals widen by it."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flex_ident.errors import ExcitationError
from flex_ident.estimation.base_fit import base_fit
from flex_ident.likelihood.covariance import Uncertainty, uncertainty_of
from flex_ident.likelihood.fit import Fit, key_bounds
from flex_ident.likelihood.nuisances import model_priors
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.remainder import Remainder, remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording
from flex_ident.screening.candidates import candidates
from flex_ident.screening.scoring import following_of, orthonormal, projected, scores
from flex_ident.screening.sketching import sketched
from flex_ident.screening.suspects import (
    Suspect,
    _Tried,
    _weighty,
    named_shift,
    suspects,
    unexplained_gap,
    widened,
)
from flex_ident.screening.thresholds import NO_CAUSE, STRONG

Floats = NDArray[np.float64]
ROWS, KEYS = 400, ("a", "b", "c")


def linear_fit(target: Floats, matrix: Floats, prior: Floats, at_bound: tuple[str, ...] = ()) -> Fit:
    """The optimum of |target - matrix x|^2 + x' diag(prior) x; keys at their bound stay at zero."""
    inside = [i for i, k in enumerate(KEYS) if k not in at_bound]
    part, x = matrix[:, inside], np.zeros(3)
    x[inside] = np.linalg.solve(part.T @ part + np.diag(prior[inside]), part.T @ target)
    rest = target - matrix @ x
    values = Values().with_vector(KEYS, x)
    return Fit(
        KEYS, values, -matrix, rest, (np.arange(ROWS),), np.diag(prior), (), at_bound, 0.5 * float(rest @ rest)
    )  # fmt: skip


def made_up(seed: int = 0) -> tuple[Floats, Floats, Floats]:
    """Columns of the model, of sizes apart by 1e6, of an effect that they imitate in part, and a target with both."""
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((ROWS, 3)) * np.array([1e-3, 1.0, 1e3])
    effect = matrix @ np.array([400.0, 0.6, -2e-4]) + rng.standard_normal(ROWS)
    return matrix, effect, matrix @ np.array([1e3, 2.0, -1e-3]) + 0.4 * effect + 0.1 * rng.standard_normal(ROWS)


def test_linear_shift_is_that_of_a_refit() -> None:
    matrix, effect, target = made_up()
    before = linear_fit(target, matrix, np.zeros(3))
    found = projected(before, -effect[:, None], orthonormal(before, ""), following_of(before))
    assert found is not None
    both = np.column_stack((matrix, effect))
    x = np.linalg.lstsq(both, target, rcond=None)[0]
    assert found.sizes[0] == pytest.approx(x[3], rel=1e-6)
    np.testing.assert_allclose(found.shift, x[:3] - before.values.vector(KEYS), rtol=1e-6)
    rest = target - both @ x
    assert found.gain == pytest.approx(float(before.residual @ before.residual - rest @ rest), rel=1e-6)


def test_model_follows_an_effect_as_its_priors_and_bounds_allow() -> None:
    """At a given size of the effect the rest is refitted with the priors in force and the key at its bound fixed."""
    matrix, effect, target = made_up(1)
    prior = np.array([1e-4, 30.0, 0.0])
    before = linear_fit(target, matrix, prior, ("b",))
    moved = following_of(before) @ (-0.4 * effect)
    after = linear_fit(target - 0.4 * effect, matrix, prior, ("b",))
    there = after.values.vector(KEYS) - before.values.vector(KEYS)
    assert moved[1] == 0.0
    np.testing.assert_allclose(moved[[0, 2]], there[[0, 2]], rtol=1e-5)


@cache
def rigid(quadratic: float) -> tuple[SteadyFit, Fit]:
    """A rigid joint with friction that grows with the square of speed, fitted without that; its law is linear."""
    t = np.arange(0.0, 24.0, 2e-3)
    phase, omega = 2 * np.pi * (0.2 * t + 0.08 * t**2), 2 * np.pi * (0.2 + 0.16 * t)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * (2 * np.pi * 0.16 * np.cos(phase) - omega**2 * np.sin(phase))
    noise = np.random.default_rng(0).normal(0.0, 0.3, t.size)
    torque = 2.0 * a + 3.0 * v + np.sign(v) + quadratic * v * np.abs(v) + noise
    solver = SteadyFit(FitProblem(Recording("j", 500.0, q, torque), rigid=True, band_hz=8.0), local=True)
    values = Values({"J": 2.0, "FV": 3.0, "FS": 1.0, "offset": 0.0})
    return solver, solver.solve(tuple(values), values, solver.whitenings(values))


@pytest.mark.parametrize(("quadratic", "strong"), [(0.01, False), (0.2, True)])
def test_a_suspect_would_move_the_model_as_a_refit_does(quadratic: float, strong: bool) -> None:
    solver, fit = rigid(quadratic)
    found = {s.effect: s for s in suspects(solver, fit, left(1.0))}
    suspect = found["viscous_nonlinearity"]
    assert suspect.strong is strong
    key = "viscous_nonlinearity.coefficient"
    refit = solver.solve((*fit.free, key), fit.values | {key: 0.0}, fit.whitenings)
    own = uncertainty_of(fit, solver.problem.rate_hz)
    for name, shift in named_shift(suspect, fit.free).items():
        assert abs(shift - (refit.values[name] - fit.values[name])) < 0.3 * own.std(name), name
    if strong:
        assert max(found.values(), key=lambda s: s.gain) is suspect
        assert suspect.gap is not None
        refitted = np.sqrt(np.mean(solver.problem.residuals(refit.values)[0][solver.problem.usable] ** 2))
        assert suspect.gap == pytest.approx(float(refitted), rel=0.02)


def test_the_likeliest_is_refitted_further(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sketch that is broken off on its way says too little of what the effect would move."""
    solver, fit = rigid(0.2)
    whole = suspects(solver, fit, left(1.0))[0]

    def part_of_the_way(*args: Any) -> Fit:
        there = sketched(*args)
        values = Values({k: 0.8 * v + 0.2 * fit.values.get(k, 0.0) for k, v in there.values.items()})
        return replace(there, values=values, cost=0.8 * there.cost + 0.2 * fit.cost)

    monkeypatch.setattr("flex_ident.screening.suspects.sketched", part_of_the_way)
    own = np.array([uncertainty_of(fit, solver.problem.rate_hz).std(k) for k in fit.free])
    for whether in (left(1.0), remainder(solver, fit)):
        further = suspects(solver, fit, whether)[0]
        assert further.effect == whole.effect
        assert further.gain == pytest.approx(whole.gain, rel=0.01)
        np.testing.assert_array_less(np.abs(further.shift - whole.shift), 0.1 * own)


def test_nothing_hidden_nothing_suspected() -> None:
    solver, fit = rigid(0.0)
    found = suspects(solver, fit, remainder(solver, fit))
    assert not [s.effect for s in found if s.strong]
    own = uncertainty_of(fit, solver.problem.rate_hz)
    wide = widened(own, found, remainder(solver, fit))
    for key in fit.free:
        assert own.std(key) <= wide.std(key) < 1.5 * own.std(key), key


def test_no_effect_is_taken_for_larger_than_it_can_be() -> None:
    """An effect that the nuisances imitate but for rounding has no size that the residual tells."""
    problem, near = rigid(0.0)[0].problem, rigid(0.0)[1]
    solver, fit = base_fit(problem, near.free, near.values, model_priors(problem))
    for score in scores(solver, fit, candidates(problem, fit.values)):
        if score.shift is None:
            continue
        for key, size in score.candidate.start(score.sizes).items():
            low, high = key_bounds(key, solver.priors)
            assert low <= size <= high, f"{key} {size:.3g}, {score.orthogonal:.1g} of it beyond the model's own"


def uncertain(seed: int = 0) -> Uncertainty:
    """A covariance with strong correlations between keys of very different sizes."""
    root = np.random.default_rng(seed).standard_normal((3, 3)) * np.array([[1e-3], [1.0], [1e3]])
    return Uncertainty(KEYS, root @ root.T, 1.0, 3, ())


def left(gap: float, floor: float = 1.0) -> Remainder:
    return Remainder(np.zeros(1), gap, floor, 0.0, None, "quiet")


@pytest.mark.parametrize("seed", range(6))
def test_widened_covariance_is_one_and_no_interval_shrinks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    before = uncertain(seed)
    scale = np.sqrt(np.diag(before.covariance))
    gains = rng.uniform(-20.0, 300.0, 8)
    found = tuple(
        Suspect(f"e{i}", float(g), 30.0 * scale * rng.standard_normal(3), float(rng.uniform(1.0, 3.0)))
        for i, g in enumerate(gains)
    )
    after = widened(before, found, left(2.0))
    added = (after.covariance - before.covariance) / np.outer(scale, scale)
    np.testing.assert_allclose(after.covariance, after.covariance.T)
    assert np.linalg.eigvalsh(added)[0] > -1e-9 * np.linalg.eigvalsh(added)[-1]
    assert np.linalg.eigvalsh(after.covariance / np.outer(scale, scale))[0] > 0.0
    for key in KEYS:
        assert after.std(key) >= before.std(key)


def test_a_certain_suspect_puts_its_whole_shift_into_the_interval_and_an_unlikely_one_nothing() -> None:
    before = uncertain()
    shift = 5.0 * np.sqrt(np.diag(before.covariance))
    certain = widened(before, (Suspect("e", 100.0, shift),), left(1.0))
    for i, key in enumerate(KEYS):
        assert certain.std(key) == pytest.approx(np.hypot(before.std(key), shift[i]), rel=1e-6)
    unlikely = widened(before, (Suspect("e", -20.0, shift),), left(1.0))
    np.testing.assert_array_equal(unlikely.covariance, before.covariance)


def test_a_suspect_far_behind_the_best_weighs_less() -> None:
    before = uncertain()
    shift = 5.0 * np.sqrt(np.diag(before.covariance))
    best = Suspect("best", 10.0 * STRONG, np.zeros(3))
    alone = widened(before, (Suspect("e", STRONG, shift),), left(1.0))
    behind = widened(before, (best, Suspect("e", STRONG, shift)), left(1.0))
    for i, key in enumerate(KEYS):
        assert behind.std(key) == pytest.approx(np.hypot(before.std(key), 0.1 * shift[i]), rel=1e-3)
        assert behind.std(key) < alone.std(key)


@pytest.mark.parametrize(
    ("gap", "suspect_gap", "factor"),
    [(1.05, None, 1.0), (3.0, None, 3.0 * NO_CAUSE), (3.0, 2.9, 2.9 * NO_CAUSE), (3.0, 1.5, 1.5), (3.0, 1.0, 1.0)],
)
def test_what_no_suspect_accounts_for_widens_everything(gap: float, suspect_gap: float | None, factor: float) -> None:
    """By its size over the noise, and by more where it is most of what is left."""
    before = uncertain()
    suspect = Suspect("e", 100.0, np.zeros(3), suspect_gap)
    after = widened(before, (suspect,), left(gap))
    assert unexplained_gap((suspect,), left(gap)) == (gap if suspect_gap is None else suspect_gap)
    for key in KEYS:
        assert after.std(key) == pytest.approx(factor * before.std(key), rel=1e-6)


def test_a_suspect_whose_refit_saves_nothing_weighs_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A linear estimate that promised much, and a refit that ends where it began or runs away: its shift was wrong."""
    solver, fit = rigid(0.2)
    name = suspects(solver, fit, left(1.0))[0].effect
    for outcome in (lambda *_args: fit, _runs_away):
        monkeypatch.setattr("flex_ident.screening.suspects.sketched", outcome)
        disproved = next(s for s in suspects(solver, fit, left(1.0)) if s.effect == name)
        assert disproved.gap is None
        assert disproved.weight < 0.01


def _runs_away(*_args: object) -> Fit:
    raise ExcitationError("runs away")


def weighty(*shifts: float, gain: float = 16.0, effect: str = "saturation") -> list[float]:
    """Which of several suspects that would shift K by so many of its standard deviations are refitted."""
    rng = np.random.default_rng(0)
    slope = np.ones((400, 1))
    fit = Fit(
        ("K",), Values({"K": 1.0}), slope, rng.standard_normal(400), (np.arange(400),), np.zeros((1, 1)), (), (), 200.0
    )
    solver: Any = SimpleNamespace(problem=SimpleNamespace(rate_hz=10.0))
    score: Any = None
    std = uncertainty_of(fit, 10.0).std("K")
    tried = [_Tried(Suspect(effect, gain, np.array([s * std])), score, solver, fit, 1.0) for s in shifts]
    return [round(float(t.suspect.shift[0]) / std, 6) for t in _weighty(tried, fit, solver)]


def test_what_would_move_a_parameter_most_is_refitted_before_it_is_believed() -> None:
    assert weighty(0.5, -3.0, 70.0, 2.0) == [70.0, -3.0]
    assert weighty(0.5, 0.9) == []
    assert weighty(70.0, gain=-20.0) == []
    assert weighty(70.0, effect="stribeck_friction") == []
