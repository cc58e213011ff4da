"""Gravity that a controller adds beside what is left of it in the effort."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flex_ident.estimation.kind_fit import KindFit
from flex_ident.estimation.kind_gain import removed_gravity, shown_moment
from flex_ident.estimation.kind_priors import largest_moment
from flex_ident.estimation.thresholds import LEFT_OVER
from flex_ident.likelihood.comparison import correlation_factor
from flex_ident.parameters import GRAVITY_KEYS
from flex_ident.recording import Floats


def with_hidden_gravity(found: KindFit) -> KindFit:
    """The fit with what more gravity would move of which the effort holds a little, in its uncertainty.

    A controller's model of the arm is never exact, and knows no tool that nobody entered: what is left in the effort
    looks like the whole weight of a lighter link. Where the effort holds less than `LEFT_OVER` of what a link of that
    inertia may weigh, as much as that may be missing, less what a link encoder tells of it. To first order, from the
    derivatives that the fit has.
    """
    fit, problem = found.fit, found.solver.problem
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    names = [fit.free[i] for i in inside]
    if not all(key in names for key in ("K", *GRAVITY_KEYS)):
        return found
    usual = 0.5 * largest_moment(fit.values["JL"])
    if shown_moment(problem, fit) > LEFT_OVER * usual:
        return found
    jacobian, prior = fit.jacobian[:, inside], fit.prior_information[np.ix_(inside, inside)]
    removed = removed_gravity(problem, found.solver, fit)
    unseen = [jacobian[:, names.index(key)] + column for key, column in zip(GRAVITY_KEYS, removed, strict=True)]
    scale = correlation_factor(fit)
    rows = np.column_stack((jacobian, *unseen)) / math.sqrt(scale)
    information = rows.T @ rows
    information[: len(inside), : len(inside)] += prior
    information[len(inside) :, len(inside) :] += np.eye(2) / usual**2
    target = -rows.T @ (fit.residual / math.sqrt(scale))
    with_it, without = _solved(information, target), _solved(information[:-2, :-2], target[:-2])
    if problem.link is None:  # what the motor alone tells of it is of second order, and nothing of that is known here
        following = -without[1] @ information[:-2, -2:]
        whole = usual**2 * np.vstack((following, np.eye(2))) @ np.hstack((following.T, np.eye(2)))
        with_it = np.append(without[0], [0.0, 0.0]), whole + np.pad(without[1], (0, 2))
    bears = np.eye(len(inside), len(inside) + 2)  # the link bears both what is left in the effort and what is not
    bears[[names.index(key) for key in GRAVITY_KEYS], [-2, -1]] = 1.0
    size = len(fit.free)
    shift, grown = np.zeros(size), np.zeros((size, size))
    shift[inside] = bears @ with_it[0] - without[0]
    grown[np.ix_(inside, inside)] = _positive(bears @ with_it[1] @ bears.T - without[1])
    at = fit.free.index("K")
    if found.rival is not None and found.open is not None:
        known = float(found.rival[at] ** 2 + found.open[at, at])
        if known > float(shift[at] ** 2 + grown[at, at]):  # all of it, fitted, reaches farther
            return found
    return replace(found, rival=shift, open=grown)


def _positive(covariance: Floats) -> Floats:
    """The covariance (p, p) without what is below nothing."""
    scale = np.sqrt(np.abs(np.diag(covariance)))
    scale[scale == 0.0] = 1.0
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    whole: Floats = (vectors * np.maximum(values, 0.0)) @ vectors.T * np.outer(scale, scale)
    return whole


def _solved(information: Floats, target: Floats) -> tuple[Floats, Floats]:
    """Solution (p,) and covariance (p, p) of the normal equations, scaled by their diagonal."""
    scale = np.sqrt(np.diag(information))
    scale[scale == 0.0] = 1.0
    inverse = np.linalg.pinv(information / np.outer(scale, scale), rcond=1e-13, hermitian=True) / np.outer(scale, scale)
    return inverse @ target, inverse
