"""Laws measured as curves: where what all names leave depends on a variable, and none of them closes it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flex_ident.effects import CATALOGUE, Effect, Probe
from flex_ident.effects.curve import Curve
from flex_ident.errors import ExcitationError
from flex_ident.gap.explanation import Rejected
from flex_ident.gap.found import Accepted, Search
from flex_ident.gap.knots import points_to_both_sides, range_points
from flex_ident.gap.options import GapOptions
from flex_ident.gap.thresholds import CURVE_COUNTS, CURVE_SHARE, MOST_CURVES
from flex_ident.gap.trials import Trial, compared, descended, final_polish
from flex_ident.gap.weighing import rebuilt, weighed
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.remainder import remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.likelihood.thresholds import STRUCTURE
from flex_ident.notices import Reason, Why
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.screening.candidates import Candidate
from flex_ident.screening.sketching import effects_in, extended_solver


def curved(search: Search, solver: SteadyFit, base: Fit, options: GapOptions) -> Search:
    """The search with measured curves, where what it leaves is more than noise and curves close it.

    A curve takes the place of the named laws that are functions of the same variable, and must close much of what they
    leave. Each number of points pays its own price.
    """
    curves = [
        e for e in CATALOGUE.values()
        if e.curve is not None and (e.name in options.effects if options.effects else e.curve.sought)
    ]  # fmt: skip
    for _ in range(MOST_CURVES):
        left = remainder(search.solver, search.fit)
        if left.gap <= STRUCTURE * left.floor:
            break
        best: tuple[Search, Trial] | None = None
        for effect in curves:
            if effect.name in effects_in(search.fit.free):
                continue
            reduced, trials = _trials(search, effect, solver, base)
            trials = [_demanding(t) for t in trials]
            good = [t for t in trials if not t.objection]
            if trials and not good:
                first = max(trials, key=lambda t: t.evidence)
                assert first.objection is not None
                search.rejected[effect.name] = Rejected(effect.name, max(0.0, first.share), first.objection)
            for trial in good:
                if best is None or trial.evidence > best[1].evidence:
                    best = reduced, trial
        if best is None:
            break
        search = weighed(_accepted(*best, search), solver, base)
    return search


def _demanding(trial: Trial) -> Trial:
    """The trial, refused where the curve leaves too much: it resembles what is missing, and is not it."""
    if trial.objection or trial.share >= CURVE_SHARE:
        return trial
    closed = {"percent": 100.0 * trial.share, "needed_percent": 100.0 * CURVE_SHARE}
    return replace(trial, objection=Reason(Why.CLOSES_LITTLE, numbers=closed, case="curve"))


def _accepted(reduced: Search, trial: Trial, before: Search) -> Search:
    """The search with the curve in it, and why the laws that it holds are no longer named."""
    others = []
    for a in before.accepted:
        if all(a.trial is not b.trial for b in reduced.accepted) and a.trial.effect not in effects_in(trial.fit.free):
            others.append(a.trial)
            reason = Reason(Why.MEASURED_INSTEAD, trial.effect)
            before.rejected[a.trial.effect] = Rejected(a.trial.effect, max(0.0, a.trial.share), reason)
    reduced.rejected.pop(trial.effect, None)
    accepted = [*reduced.accepted, Accepted(trial, False, reduced.fit, tuple(others))]
    fit = final_polish(trial.solver, trial.fit)
    return Search(trial.solver, reduced.base, fit, accepted, reduced.rejected, reduced.untestable)


def _trials(search: Search, effect: Effect, solver: SteadyFit, base: Fit) -> tuple[Search, list[Trial]]:
    """The search without the named laws that the curve holds, and the curve tried in it with few and more points."""
    assert effect.curve is not None
    kept = [a for a in search.accepted if a.by_hand or a.trial.effect not in effect.curve.contains]
    try:
        reduced = search if len(kept) == len(search.accepted) else rebuilt(search, kept, solver, base)
    except ExcitationError:
        return search, []
    trials = []
    for candidate in curve_candidates(effect, search.solver.problem, reduced.fit.values):
        extended, keys = extended_solver(reduced.solver, reduced.fit.free, candidate)
        start = reduced.fit.values | candidate.start((1.0,))
        try:
            after = descended(extended, keys, start, search.fit)
        except ExcitationError:
            continue
        trials.append(compared(extended, search.fit, after, candidate, reduced.own_error()))
    return reduced, trials


def curve_candidates(effect: Effect, problem: FitProblem, values: Values) -> Iterator[Candidate]:
    """The effect's curve at no torque, through few points and through more."""
    curve = effect.curve
    if curve is None or (effect.needs_spring and problem.rigid):
        return
    tried: set[int] = set()
    for count in CURVE_COUNTS:
        at = _points(curve, problem, values, count)
        if at.size < 4 or at.size in tried:
            continue
        tried.add(at.size)
        parameters = curve.parameters_of(at, np.zeros(at.size))
        scaled = tuple(k for k in parameters if not effect.parameter(k).fixed)
        yield Candidate(effect.name, Probe((parameters,), scaled, one_sided=False, smooth=True))


def _points(curve: Curve, problem: FitProblem, values: Values, count: int) -> Floats:
    """Where at most `count` points lie to each side of zero, or twice as many over the range."""
    if curve.each_direction:
        return points_to_both_sides(problem, problem.motion.velocity, count, problem.resolution)
    if not curve.anchored:
        return range_points(problem, problem.motion.position, 2 * count)
    link = problem.link_response_of(values)
    assert link is not None
    return range_points(problem, problem.motion.position - link.position, 2 * count)
