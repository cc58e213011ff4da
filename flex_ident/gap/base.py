"""The base model of the search, fitted."""

from __future__ import annotations

from flex_ident.estimation.estimate import refined, started_values
from flex_ident.gap.options import GapOptions
from flex_ident.likelihood.fit import Fit, SimulationFit
from flex_ident.likelihood.nuisances import search_priors
from flex_ident.likelihood.problem import FitProblem, values_of
from flex_ident.likelihood.steady import SteadyFit


def base_keys(options: GapOptions) -> tuple[str, ...]:
    """Keys of the base model, effects of a given model included."""
    keys = tuple(k for k in options.base_catalogue if k not in options.without)
    if options.model is None:
        return keys
    given = tuple(k for k in values_of(options.model) if k not in options.without)
    return tuple(dict.fromkeys((*keys, *given)))


def base_fit(problem: FitProblem, options: GapOptions) -> tuple[SteadyFit, Fit]:
    """The base model fitted to everything, and the solver that did it. Raises ExcitationError."""
    keys = base_keys(options)
    if options.model is not None:
        given = values_of(options.model)
        start = {k: given.get(k, 0.0) for k in keys}
    else:
        found = started_values(problem, keys, first_mode_hz=options.first_mode_hz)
        start = {k: found.get(k, 0.0) for k in keys}
    priors = search_priors(problem, [k.split(".")[0] for k in keys if "." in k])
    free = (*keys, *priors)
    values = refined(SimulationFit(problem, priors=priors), free, start).values
    solver = SteadyFit(problem, priors=priors)
    fit = solver.solve(free, values, solver.whitenings(values), iterations=12, tolerance=1e-5)
    fit = solver.solve(free, fit.values, solver.whitenings(fit.values), iterations=8, tolerance=1e-5)
    return solver, fit
