"""The base model whose gap is sought: the one that `identify` fits, and what of it the search must find by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flex_ident.effects import CATALOGUE, Effect, is_fixed
from flex_ident.estimation.base_fit import base_fit
from flex_ident.estimation.effort_kind import resolved
from flex_ident.estimation.identification import base_start
from flex_ident.estimation.kind_fit import KindFit
from flex_ident.estimation.kind_priors import base_priors
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap.options import GapOptions
from flex_ident.gap.thresholds import CERTAIN
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters.effort_kinds import GRAVITY_REMOVED, REMOVED_KEYS
from flex_ident.parameters.parameter import FAR_MODE
from flex_ident.parameters.values import Values
from flex_ident.screening.sketching import known_beforehand

SEARCH_ROUNDS = ((10, 1e-5), (8, 1e-5))
"""Iterations and tolerance of the fits that the search starts from and ends with."""


@dataclass(frozen=True)
class GapBase:
    """The base model of a search, and the effects that keys and nuisances left out of it stood for until then."""

    kinds: KindFit
    stood_for: tuple[Effect, ...]
    whole: KindFit
    """The same with all that identification corrects for."""


def fitted_base(problem: FitProblem, options: GapOptions, whole: KindFit | None = None) -> GapBase:
    """The base model, fitted as `identify` fits it, under the kind of effort that holds. Raises ExcitationError.

    What identification corrects for and what is an effect by itself, a constant torque, a signal that is more than a
    sample late, friction that bends before it slides, is left out of the base where the recording shows it: the search
    then finds it. `whole` is identification's own fit, where it is at hand.
    """
    whole = whole or _whole(problem, options)
    fit, keys = whole.fit, tuple(k for k in whole.fit.free if k not in whole.solver.priors)
    problem = whole.solver.problem
    stood_for = _stood_for(problem, fit, keys, options)
    if not stood_for and not _late(problem, fit.values):
        return GapBase(whole, (), whole)
    known = known_beforehand(whole.solver)
    shown_by = {k for effect in stood_for for k in effect.shown_by}
    few = tuple(k for k in keys if k not in shown_by)
    near = fit.values.only([k for k in fit.values if k in few or _given(k)])
    few = tuple(k for k in few if k not in known)
    priors = {**base_priors(problem, few, late_samples=1.0), **known}
    for key in shown_by:
        priors.pop(key, None)
    return GapBase(whole.refitted(*base_fit(problem, few, near, priors)), stood_for, whole)


def _whole(problem: FitProblem, options: GapOptions) -> KindFit:
    own = IdentifyOptions(
        sensors=options.sensors, rigid=options.rigid, first_mode_hz=options.first_mode_hz, model=options.model,
        effort_kind=options.effort_kind, band_hz=options.band_hz,
    )  # fmt: skip
    keys, start = base_start(problem, own, prismatic=options.prismatic)
    keys = tuple(k for k in keys if k not in options.without)
    start = start.only([k for k in start if k in keys or _given(k)])
    solver, fit = base_fit(problem, keys, start, base_priors(problem, keys, options.effort_kind))
    return resolved(solver.problem, solver, fit, options.effort_kind)


def _given(key: str) -> bool:
    """Whether it is part of the model and no key of the joint: where a curve's points lie, what is taken off."""
    return key in REMOVED_KEYS or is_fixed(key)


def _stood_for(problem: FitProblem, fit: Fit, keys: Sequence[str], options: GapOptions) -> tuple[Effect, ...]:
    """The effects that may be sought and that a nuisance, or one of the base's `keys`, stands for beyond doubt.

    A constant is the joint's own where it slides or is rigid, and where the effort is without gravity: there it is what
    the controller holds it with.
    """
    uncertainty = uncertainty_of(fit, problem.rate_hz)
    own = problem.rigid or options.prismatic or GRAVITY_REMOVED in fit.values
    return tuple(
        e for e in CATALOGUE.values()
        if (not options.effects or e.name in options.effects) and e.name not in options.staying
        and any(
            abs(fit.values[k]) > CERTAIN * uncertainty.std(k) > 0.0
            for k in e.shown_by if k in fit.free and not (own and k in keys)
        )
    )  # fmt: skip


def _late(problem: FitProblem, values: Values) -> bool:
    late = (abs(values.get(e.replaces, 0.0)) for e in CATALOGUE.values() if e.replaces)
    return max(late) > problem.recording.sample_time


def search_start(problem: FitProblem, base: SteadyFit, fit: Fit) -> tuple[SteadyFit, Fit]:
    """The fit of a base to search from: weighted by the steady noise alone, so that what is missing stands out.

    Without a mode above the band, which takes much of what a base lacks for itself.
    """
    free = tuple(k for k in fit.free if k != FAR_MODE)
    priors = {**base_priors(problem, free, late_samples=1.0), **known_beforehand(base)}
    priors.pop(FAR_MODE, None)
    solver = SteadyFit(problem, priors=priors)
    return solver, polished(solver, free, fit.values.without((FAR_MODE,)))


def polished(solver: SteadyFit, keys: Sequence[str], values: Values) -> Fit:
    """The fit over `keys` from values near its optimum. Raises ExcitationError."""
    fit: Fit | None = None
    for iterations, tolerance in SEARCH_ROUNDS:
        fit = solver.finished(keys, values, solver.whitenings(values), iterations=iterations, tolerance=tolerance)
        values = fit.values
    assert fit is not None
    return fit
