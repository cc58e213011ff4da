"""What one kind of effort gains over another: by two fits under one noise, or by a single linear step."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from flex_ident.likelihood.comparison import correlation_factor
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters import GRAVITY_KEYS
from flex_ident.recording import Floats
from flex_ident.simulation.terms import GRAVITY


@dataclass(frozen=True)
class Gain:
    """Twice the log-likelihood that one fit gains over another under one noise, in independent samples, and the share
    that it saves of what the other leaves above that noise, of torque or link position, whichever is more."""

    size: float
    share: float


def gain_of(problem: FitProblem, solver: SteadyFit, before: Fit, after: Fit) -> Gain:
    """What `after` gains over `before`, the noise being the less of what either shows."""
    plain = SteadyFit(problem, priors=solver.priors, marks=solver.marks)
    choices = [plain.whitenings(f.values) for f in (before, after)]
    whitenings = tuple(min(pair, key=lambda w: w.scale) for pair in zip(*choices, strict=True))
    one, two = (plain.whitened_residual(f.values, whitenings) for f in (before, after))
    cost, other = float(one @ one), float(two @ two)
    count = min(one.size, two.size)
    rows = plain.rows(whitenings)
    correlated = correlation_factor(replace(after, residual=two, rows=rows))
    size = max(min(cost, other) / count, 1.0)
    # By channel: what one of them cannot show must not hide what the other does.
    ends = np.cumsum([0, *(r.size for r in rows)])
    shares = [_saved(one[a:b], two[a:b]) for a, b in pairwise(ends)]
    share = max(shares)
    return Gain((cost - other) / size / correlated, share)


def _saved(one: Floats, two: Floats) -> float:
    """Share that the whitened residual `two` saves of what `one` has above the noise."""
    before, after = float(one @ one), float(two @ two)
    return (before - after) / max(before - one.size, 1e-300) if before > one.size else 0.0


def removed_gravity(problem: FitProblem, solver: SteadyFit, fit: Fit) -> list[Floats]:
    """What each first moment of 1 kg m that the controller takes off the effort adds to the whitened residual, (r,)."""
    position = problem.motion.position
    nothing = [np.zeros(problem.time.size)] * (len(fit.whitenings) - 1)
    late = float(fit.values.get("torque_delay", 0.0))
    return [
        solver.whitened((GRAVITY * problem.reduced(shape, delay=late), *nothing), fit.whitenings)
        for shape in (np.cos(position), np.sin(position))
    ]


def shown_moment(problem: FitProblem, fit: Fit) -> float:
    """The first moment, kg m, that the effort shows: by what holds the link at the mean position, any offset included,
    and by how that changes with the angle, each less two standard deviations.

    Over a small range gravity's bend alone tells a weight to the side from an offset, and what is a thousandth of the
    torque bends as much.
    """
    here, keys = float(np.mean(problem.motion.position)), [*GRAVITY_KEYS, "offset"]
    cosine, sine = math.cos(here), math.sin(here)
    ways = np.array([[cosine, sine, 1.0 / GRAVITY], [-sine, cosine, 0.0]])
    free = [i for i, key in enumerate(keys) if key in fit.free]
    rows = [fit.free.index(keys[i]) for i in free]
    known = uncertainty_of(fit, problem.rate_hz).covariance[np.ix_(rows, rows)]
    std = np.sqrt(np.einsum("ij,jk,ik->i", ways[:, free], known, ways[:, free]))
    sizes = np.abs(ways @ [fit.values.get(key, 0.0) for key in keys]) - 2.0 * std
    return float(np.linalg.norm(np.maximum(sizes, 0.0)))


def linear_gain(problem: FitProblem, solver: SteadyFit, fit: Fit) -> float:
    """Twice the log-likelihood, to first order, that an effort without gravity gains over one with it.

    What is recorded is then the motor's torque less g (MX cos qm + MY sin qm): two columns that need no simulation.
    """
    removed = removed_gravity(problem, solver, fit)
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    jacobian, prior = fit.jacobian.copy(), np.sqrt(np.diag(fit.prior_information))
    rest = fit.residual.copy()
    costs = [_least(jacobian[:, inside], rest, prior[inside])]
    for key, column in zip(GRAVITY_KEYS, removed, strict=True):
        jacobian[:, fit.free.index(key)] += column
        rest = rest + fit.values[key] * column
    costs.append(_least(jacobian[:, inside], rest, prior[inside]))
    size = max(min(costs) / rest.size, 1.0)
    return (costs[0] - costs[1]) / size / correlation_factor(fit)


def _least(jacobian: Floats, rest: Floats, prior: Floats) -> float:
    """The least sum of squares of a linearised problem, priors included."""
    matrix = np.concatenate((jacobian, np.diag(prior)))
    target = np.concatenate((rest, np.zeros(prior.size)))
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    solution = np.linalg.lstsq(matrix / scale, -target, rcond=1e-10)[0]
    left = target + matrix / scale @ solution
    return float(left @ left)
