"""What the link's dry friction would do to the parameters, turned over with speed and not at once.

The motor's friction has a nuisance for that, whose own motion tells it. The link's turns over at once in the
simulation: where it does not, its viscous friction takes up what the dry one lacks at low speed.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.estimation.base_fit import cost_of
from flex_ident.estimation.thresholds import TURNOVER_SPEEDS
from flex_ident.likelihood.comparison import correlation_factor
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.gauge import prior_root
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.screening.scoring import whitened_change
from flex_ident.simulation.terms import Term

KEY = "link_turnover"
SURE, TRIED = 20.0, 3
"""Twice the log-likelihood, to first order, from which friction is fitted so, and how many speeds are tried then."""
ITERATIONS, TOLERANCE = 12, 1e-3


def turnover_shift(solver: SteadyFit, fit: Fit) -> Floats | None:
    """What it would change in the free values (p,) at the likeliest of a few speeds; less of what is no larger than
    chance would make it. None for a rigid joint, without friction on the link, and where at once is likelier."""
    problem = solver.problem
    link = problem.link_response_of(fit.values)
    if link is None or not problem.terms(fit.values)[Term.LINK_COULOMB] > 0.0:
        return None
    speed = float(np.std(link.velocity))
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    known = prior_root(fit.prior_information[np.ix_(inside, inside)])
    target = np.concatenate((-fit.residual, np.zeros(known.shape[0])))
    alone = np.concatenate((fit.jacobian[:, inside], known))
    best, shift = 0.0, None
    speeds = [share * speed for share in TURNOVER_SPEEDS]
    gains = []
    for turnover in speeds:
        column = whitened_change(solver, fit, Values({KEY: turnover}))
        if not np.isfinite(column).all():
            continue
        rows = np.column_stack((alone, np.concatenate((column, np.zeros(known.shape[0])))))
        scale = np.linalg.norm(rows, axis=0)
        scale[scale == 0.0] = 1.0
        solution = np.linalg.lstsq(rows / scale, target, rcond=1e-9)[0] / scale
        gain = float(target @ (rows @ solution)) / correlation_factor(fit)
        gains += [(gain, turnover)] if solution[-1] > 0.0 else []
        if solution[-1] > 0.0 and gain > best:
            best, shift = gain, np.zeros(len(fit.free))
            shift[inside] = gain / (1.0 + gain) * solution[:-1]
    return (
        _fitted(solver, fit, [t for g, t in sorted(gains, reverse=True)[:TRIED] if g > SURE]) if best > SURE else shift
    )


def _fitted(solver: SteadyFit, fit: Fit, speeds: Sequence[float]) -> Floats | None:
    """What the likeliest fit with one of these speeds changes in the free values (p,); None where none is likelier.

    Where such a friction shows beyond doubt a step by derivatives is too short: FS of a harmonic drive in quick steps
    was 8 standard deviations off with it.
    """
    least, shift = cost_of(solver, fit.values, fit.whitenings), None
    for speed in speeds:
        with suppress(ExcitationError):
            there = solver.solve(
                fit.free, fit.values | {KEY: speed}, fit.whitenings, iterations=ITERATIONS, tolerance=TOLERANCE,
                rough=True,
            ).values  # fmt: skip
            cost = cost_of(solver, there, fit.whitenings)
            if cost < least:
                least, shift = cost, there.vector(fit.free) - fit.values.vector(fit.free)
    return shift
