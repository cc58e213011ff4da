"""Friction as a curve over speed, one for each direction: what a recording of a rigid joint says without a law.

The torque less gravity is a sum of inertia times acceleration, a constant, and a function of speed, straight between
nodes: linear in J, the constant and the values at the nodes, filtered like the measurement, and fitted to it by least
squares. A constant torque and friction that differs between the directions by a constant are one thing: friction is
taken as alike in both at the slowest speeds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flex_ident.estimation.thresholds import CURVE_BEND, CURVE_NODES, CURVE_QUANTILES, CURVE_SECONDS, CURVE_SPREAD
from flex_ident.likelihood.covariance import Uncertainty, uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.friction_curve import FrictionCurve
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.curves import bend
from flex_ident.simulation.terms import Term

TAKEN_OFF = ("MX", "MY")


def friction_curve(problem: FitProblem, fit: Fit, uncertainty: Uncertainty) -> FrictionCurve | None:
    """Friction over speed of a rigid joint under a fit, or None where too little moves.

    The interval holds noise that lasts, what gravity leaves open, by the fit's own uncertainty, and what a curve that
    bends between the nodes may differ by.
    """
    terms = problem.terms(fit.values)
    share, velocity = problem.friction_share(terms), problem.motion.velocity
    sides = [_nodes(problem, velocity, share, sign) for sign in (-1.0, 1.0)]
    if not any(nodes.size for nodes in sides):
        return None
    chain = {
        "delay": float(terms[Term.TORQUE_DELAY]),
        "curvature": float(terms[Term.TORQUE_AVERAGING]) * problem.recording.sample_time**2,
        "lag": float(terms[Term.EFFORT_LAG]),
    }
    hats: list[Floats] = []
    for sign, nodes in zip((-1.0, 1.0), sides, strict=True):
        side = np.maximum(sign * share, 0.0)
        hats += [sign * side * np.interp(np.abs(velocity), nodes, unit) for unit in np.eye(nodes.size)]
    # Which value each node has: the slowest of both directions have one.
    holds = np.arange(len(hats))
    columns = [problem.motion.acceleration]
    if all(nodes.size for nodes in sides):
        columns.append(np.ones_like(velocity))
        holds[sides[0].size] = 0
        holds[sides[0].size + 1 :] -= 1
    known = len(columns)
    columns += [
        sum(h for h, held in zip(hats, holds, strict=True) if held == i) + 0.0 * velocity
        for i in range(int(holds[-1]) + 1)
    ]
    rows = np.flatnonzero(problem.usable)
    matrix = np.column_stack([problem.reduced(column, **chain)[rows] for column in columns])
    plain = fit.values.only(TAKEN_OFF)
    chained = fit.values.only(("torque_delay", "torque_averaging", "effort_lag"))
    target = (problem.measured_torque(fit.values) - problem.prediction(plain | chained).torque)[rows]
    scale = np.linalg.norm(matrix, axis=0)
    if not (scale > 0.0).all():
        return None
    inverse = np.linalg.pinv(matrix / scale) / scale[:, None]
    values = inverse @ target
    covariance = _covariance(problem, matrix, target - matrix @ values, rows)
    open_ = [k for k in TAKEN_OFF if k in uncertainty.free and np.isfinite(uncertainty.std(k))]
    if open_:
        taken = np.column_stack([problem.prediction(Values({k: 1.0}) | chained).torque[rows] for k in open_])
        moved = inverse @ taken
        at = [uncertainty.free.index(k) for k in open_]
        covariance = covariance + moved @ uncertainty.covariance[np.ix_(at, at)] @ moved.T
    speed = np.concatenate((-sides[0], sides[1]))
    signed = np.concatenate((-np.ones(sides[0].size), np.ones(sides[1].size)))
    found, std = values[known:][holds], np.sqrt(np.diag(covariance))[known:][holds]
    bent = np.concatenate(
        [bend(nodes, own) for nodes, own in zip(sides, np.split(found, [sides[0].size]), strict=True)]
    )
    order = np.argsort(speed)
    return FrictionCurve(speed[order], (signed * found)[order], np.hypot(std, CURVE_BEND * bent)[order])


def _nodes(problem: FitProblem, velocity: Floats, share: Floats, sign: float) -> Floats:
    """Speeds of one direction between which the curve is straight: quantiles of those that occur for long enough."""
    speeds = np.abs(velocity[(sign * share > CURVE_SPREAD) & (np.abs(velocity) > problem.resolution)])
    held = speeds.size * problem.recording.sample_time
    count = int(min(CURVE_NODES, held / CURVE_SECONDS))
    if count < 2:
        return np.zeros(0)
    found: list[float] = []
    for node in np.quantile(speeds, np.linspace(*CURVE_QUANTILES, count)).tolist():
        if not found or node > found[-1] + problem.resolution:
            found.append(node)
    return np.array(found) if len(found) > 1 else np.zeros(0)


def _covariance(problem: FitProblem, matrix: Floats, left: Floats, rows: NDArray[np.int64]) -> Floats:
    """Covariance (p, p) of a least-squares solution whose residual `left` (r,) is correlated in time."""
    size = float(np.std(left)) or 1.0
    names = tuple(f"c{i}" for i in range(matrix.shape[1]))
    unmoved = Values(dict.fromkeys(names, 0.0))
    whole = Fit(
        names, unmoved, matrix / size, left / size, (rows,), np.zeros((len(names), len(names))), (), (),
        0.5 * left.size,
    )  # fmt: skip
    return uncertainty_of(whole, problem.rate_hz).covariance
