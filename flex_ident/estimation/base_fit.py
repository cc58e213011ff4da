"""The fit of a base model that everything is judged by: from a start to the optimum, and tried again from another.

A fit can stall where nuisances share what the joint does: a link encoder's scale and a lag in the effort held K 9 % off
in one recording of `bench/coverage.py` (seed 131), at a point that the joint's own values beat by far. So it is tried
again with all nuisances where they start; where that ends lower, the fit goes on from there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.estimation.thresholds import (
    CREEPING,
    HARDLY_CREEPS,
    LEAST_MOVING,
    LOWER,
    SEEN,
    STILL,
    TURNS_OVER,
    WORTH_TRYING,
)
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit, Prior, SimulationFit
from flex_ident.likelihood.minimising import bounded_minimum
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.reversals import dry_friction
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.likelihood.whitening import Whitening
from flex_ident.parameters.effort_kinds import FRICTION_REMOVED, FRICTION_REMOVED_SPEED
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats

Progress = Callable[[float], None]
LATER = (
    "effort_lag",
    "reversal_speed",
    "presliding",
    "reversal_lead",
    "far_mode",
    FRICTION_REMOVED,
    FRICTION_REMOVED_SPEED,
)
"""Nuisances that wait until the model is nearly right."""
FIRST_ROUNDS = ((12, 1e-3), (10, 1e-4))
ROUNDS = ((10, 1e-4), (10, 1e-5), *((15, 1e-7),) * 5)
"""Jacobians, and share of the cost saved at which a round ends."""
STATE_ROUNDS = 2
"""Rounds in which the link's state at the start is still fitted: later ones move it no more than its kinks let it."""
FIRST_S, UNSETTLED, FEWEST_ROWS = 4.0, 1.5, 60
"""First seconds of a recording; how much worse than the rest they are where the start is in doubt; samples needed."""
STATE_STEP, STATE_ITERATIONS = 1e-4, 10
NOT_PUT_BACK = ("torque_delay", "link_zero", "initial_deflection", "initial_velocity")
"""Nuisances that are not put back: any model finds them, and none does without."""
AGAIN_ROUNDS, AGAIN_ITERATIONS, AGAIN_TOLERANCE = 2, 8, 1e-3
KINK_STDS, KINK_SHARE = (-5.0, 5.0, -12.0, 12.0, -20.0, 20.0), 0.6
"""Standard deviations of the link's dry friction at which the likelihood is looked at, and the share of what it should
have fallen by there below which a fit is begun there. Set by hand: 0.1 to 0.5 at the one or the other of these in six
such recordings."""
LINK_SHARES, MOVES_ON = (0.05, 0.1, 0.2, 0.4, 0.7), 0.95
"""Shares of all dry friction that are tried as the link's, and the share of samples in which the motor moves above
which they are not. Of steps and staircases of `bench/plants` (seed 9001) three of six had ended 10 to 30 in
log-likelihood, one 150, behind what some of these led to."""
AS_LIKELY = 1.0
"""Log-likelihood by which two ends of a fit may differ and count as alike: 1.4 standard deviations of one key."""


def base_fit(
    problem: FitProblem,
    keys: Sequence[str],
    start: Values,
    priors: Mapping[str, Prior],
    *,
    progress: Progress | None = None,
) -> tuple[SteadyFit, Fit]:
    """The fit over `keys` and the nuisances of `priors`, and the solver that did it: what everything is judged by.

    First without the nuisances that only a nearly right model can tell (how friction turns over, a low-pass in the
    effort), weighted by all that is left; then with all, weighted by the noise, taken anew in each round until
    that moves nothing; then from another start. Raises ExcitationError when the simulation runs away.
    """
    done, rounds = 0, len(FIRST_ROUNDS) + len(ROUNDS)

    def step() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done / rounds)

    values = rough_values(problem, keys, start, priors, step=step)
    solver, fit = refined(problem, keys, settled(problem, values, priors), priors, step=step)
    moving = without_creeping(problem, fit)
    if moving is not problem:
        solver, fit = refined(moving, keys, fit.values, priors)
    return across_kinks(*tried_again(solver, fit))


def across_kinks(solver: SteadyFit, fit: Fit) -> tuple[SteadyFit, Fit]:
    """The fit, or one that is found beyond a kink in the link's dry friction, if its likelihood is higher.

    Where the link comes to rest in one model and not in the next the likelihood kinks, and a fit may stop short: clean
    trapezoidal moves with rests had FS 30 to 90 % off, 4 to 13 standard deviations, and up to 26 in log-likelihood
    behind the truth. A likelihood that rises by far less than its curvature foretells shows it; where the motor rests
    for much of the time, half of FS and twice as much are tried in any case.
    """
    best = fit.values
    for there in (*_less_steep(solver, fit, "FS"), *_other_shares(solver, fit)):
        try:
            again = solver.solve(
                fit.free, there, fit.whitenings, iterations=AGAIN_ITERATIONS, tolerance=AGAIN_TOLERANCE, rough=True
            ).values
        except ExcitationError:
            continue
        if cost_of(solver, best, fit.whitenings) - cost_of(solver, again, fit.whitenings) > AS_LIKELY:
            best = again
    if best is fit.values:
        return solver, fit
    try:
        return refined(solver.problem, [k for k in fit.free if k not in solver.priors], best, solver.priors)
    except ExcitationError:
        return solver, fit


def _other_shares(solver: SteadyFit, fit: Fit) -> Iterator[Values]:
    """Values in which the link has another share of all dry friction, where the motor rests for long: what both take
    together is known far better than who of the two does."""
    keys = ("FSm", "FS")
    moves = float(solver.problem.usable.mean())
    if any(key not in fit.free or key in solver.priors for key in keys) or moves > MOVES_ON:
        return
    both = sum(fit.values[key] for key in keys)
    for share in LINK_SHARES:
        yield fit.values | {"FSm": (1.0 - share) * both, "FS": share * both}


def _less_steep(solver: SteadyFit, fit: Fit, key: str) -> Iterator[Values]:
    """Values some standard deviations of a key away, the others following, at which the likelihood has fallen by far
    less than it should have."""
    if key not in fit.free or key in fit.at_bound:
        return
    inside = [i for i, k in enumerate(fit.free) if k not in fit.at_bound]
    information = fit.jacobian[:, inside].T @ fit.jacobian[:, inside] + fit.prior_information[np.ix_(inside, inside)]
    scale = np.sqrt(np.diag(information))
    scale[scale == 0.0] = 1.0
    spread = np.linalg.pinv(information / np.outer(scale, scale), hermitian=True) / np.outer(scale, scale)
    at = inside.index(fit.free.index(key))
    if not spread[at, at] > 0.0:
        return
    move = np.zeros(len(fit.free))
    move[inside] = spread[:, at] / math.sqrt(spread[at, at])
    here, cost = fit.values.vector(fit.free), cost_of(solver, fit.values, fit.whitenings)
    for stds in KINK_STDS:
        there = fit.values.with_vector(fit.free, here + stds * move)
        risen = cost_of(solver, there, fit.whitenings) - cost if there[key] > 0.0 else math.inf
        if risen < KINK_SHARE * 0.5 * stds**2:
            yield there


def without_creeping(problem: FitProblem, fit: Fit) -> FitProblem:
    """The problem without what is faster than the encoder resolves and yet no motion: friction that holds the motor
    lets it creep, and turns over in less time than a sample takes. The same problem where there is little of that, and
    where the recording does not show that friction turns over with the speed.
    """
    inertia, friction = fit.values.get("Jm", fit.values.get("J", 0.0)), dry_friction(fit.values)
    speed = fit.values.get("reversal_speed", 0.0)
    if inertia * speed > TURNS_OVER * friction * problem.recording.sample_time:
        return problem
    moving = problem.resting_below(CREEPING * speed)
    share = float(moving.usable.sum()) / float(problem.usable.sum())
    if not LEAST_MOVING < share < HARDLY_CREEPS:
        return problem
    return moving if speed > SEEN * uncertainty_of(fit, problem.rate_hz).std("reversal_speed") else problem


def refined(
    problem: FitProblem,
    keys: Sequence[str],
    values: Values,
    priors: Mapping[str, Prior],
    *,
    step: Callable[[], None] = lambda: None,
) -> tuple[SteadyFit, Fit]:
    """The fit over `keys` and all nuisances from values of a model that is nearly right. Raises ExcitationError."""
    solver, every = SteadyFit(problem, priors=priors, local=True), tuple(dict.fromkeys((*keys, *priors)))
    fit: Fit | None = None
    for done, (iterations, tolerance) in enumerate(ROUNDS):
        _refuse_runaway(problem, values)
        whitenings, state = solver.whitenings(values), done < STATE_ROUNDS
        fit = solver.finished(every, values, whitenings, iterations=iterations, tolerance=tolerance, state=state)
        moved = np.array([fit.values[k] - values.get(k, np.inf) for k in fit.free])
        values = fit.values
        step()
        if np.linalg.norm(fit.jacobian @ moved) < STILL:
            break
    assert fit is not None
    return solver, fit


def tried_again(solver: SteadyFit, fit: Fit) -> tuple[SteadyFit, Fit]:
    """The fit, or the one that is found with all nuisances where they start, if its likelihood is clearly higher.

    One that is as likely is kept beside the fit, as its `rival`.
    """
    try:
        again, led = _anew(solver, fit)
        if led < WORTH_TRYING:
            return solver, replace(fit, rival=again) if abs(led) < AS_LIKELY else fit
        keys = [k for k in fit.free if k not in solver.priors]
        own, found = refined(solver.problem, keys, again, solver.priors)
    except ExcitationError:
        return solver, fit
    if clearly_lower(solver, found, fit):
        return own, found
    led = cost_of(solver, fit.values, fit.whitenings) - cost_of(solver, found.values, fit.whitenings)
    return solver, replace(fit, rival=found.values) if abs(led) < AS_LIKELY else fit


def with_nuisances_anew(solver: SteadyFit, fit: Fit) -> Values | None:
    """Where the fit goes with all nuisances put back to where they start; None where that is no better.

    Raises ExcitationError.
    """
    again, led = _anew(solver, fit)
    return again if led >= WORTH_TRYING else None


def _anew(solver: SteadyFit, fit: Fit) -> tuple[Values, float]:
    """Where a few steps lead with all nuisances put back to where they start, and by how much log-likelihood that is
    ahead of the fit. Raises ExcitationError."""
    again = fit.values | {k: p.start for k, p in solver.priors.items() if k in fit.free and k not in NOT_PUT_BACK}
    for _ in range(AGAIN_ROUNDS):
        weights = solver.whitenings(again)
        again = solver.solve(
            fit.free, again, weights, iterations=AGAIN_ITERATIONS, tolerance=AGAIN_TOLERANCE, rough=True
        ).values
    return again, cost_of(solver, fit.values, weights) - cost_of(solver, again, weights)


def clearly_lower(solver: SteadyFit, found: Fit, fit: Fit) -> bool:
    """Whether a fit is clearly better than another: under the weights of both, each the noise that it sees itself."""
    return all(
        cost_of(solver, found.values, f.whitenings) < cost_of(solver, fit.values, f.whitenings) - LOWER
        for f in (fit, found)
    )  # fmt: skip


def cost_of(solver: SteadyFit, values: Values, whitenings: tuple[Whitening, ...]) -> float:
    """Half the sum of squares at these values under these weights, with what is known of the nuisances."""
    rest = solver.whitened_residual(values, whitenings)
    known = [(values[k] - p.mean) / p.std for k, p in solver.priors.items() if k in values]
    return 0.5 * float(rest @ rest + np.square(known).sum())


def rough_values(
    problem: FitProblem,
    keys: Sequence[str],
    start: Values,
    priors: Mapping[str, Prior],
    *,
    step: Callable[[], None] = lambda: None,
) -> Values:
    """The fit over `keys` and the nuisances that any model can tell, weighted by all that is left; `step` is called
    after each round. Raises ExcitationError."""
    rough = SimulationFit(problem, priors=priors)
    few = tuple(dict.fromkeys((*keys, *(k for k in priors if k not in LATER))))
    values = Values({k: p.start for k, p in priors.items()}) | start
    for iterations, tolerance in FIRST_ROUNDS:
        _refuse_runaway(problem, values)
        values = rough.solve(
            few, values, rough.whitenings(values), iterations=iterations, tolerance=tolerance, rough=True
        ).values
        step()
    return values


def settled(problem: FitProblem, values: Values, priors: Mapping[str, Prior]) -> Values:
    """The values with the link's state at the start from the first seconds alone, where it is in doubt there.

    Of a model that is nearly right. Stretches that it leaves badly weigh little: the first would never be mended.
    """
    keys = [k for k in ("initial_deflection", "initial_velocity") if k in priors]
    rows = problem.usable & (problem.time < FIRST_S)
    later = problem.usable & ~rows
    if not keys or min(rows.sum(), later.sum()) < FEWEST_ROWS:
        return values
    left = problem.residuals(values)[0]
    if float(np.std(left[rows])) < UNSETTLED * float(np.std(left[later])):
        return values
    scale = np.array([priors[k].std for k in keys])

    def residual(x: Floats) -> Floats:
        return np.nan_to_num(problem.residuals(values.with_vector(keys, x * scale))[0][rows], nan=1e6)

    def jacobian(x: Floats) -> Floats:
        here = residual(x)
        return np.column_stack([(residual(x + STATE_STEP * e) - here) / STATE_STEP for e in np.eye(len(keys))])

    lower, upper = (np.array([getattr(priors[k], side) for k in keys]) / scale for side in ("lower", "upper"))
    here = values.vector(keys) / scale
    ends = [
        bounded_minimum(residual, jacobian, x, lower, upper, iterations=STATE_ITERATIONS, tolerance=1e-3)[0]
        for x in (here, np.zeros(len(keys)))
    ]
    found = min(ends, key=lambda x: float(np.sum(residual(x) ** 2)))
    return values.with_vector(keys, found * scale)


def _refuse_runaway(problem: FitProblem, values: Values) -> None:
    if not all(np.isfinite(r).all() for r in problem.residuals(values)):
        raise ExcitationError("no spring in the excited band explains the torque: the simulated link runs away.")
