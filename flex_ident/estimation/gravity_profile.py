"""What the likelihood says of a gravity that an effort does not hold, over all sizes that it may have.

Such an effort shows gravity by its stiffness alone. To first order in that stiffness k over K its torque is that of a
joint without gravity of a stiffness K - k, and a link inertia smaller in the ratio of the squares: so the fit lies in a
valley along which K, JL and gravity follow each other, with more than one bottom, or a flat one. What the slope at one
point of it says of the rest is nothing. So the valley is walked, with K held.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.estimation.gravity_kind import unlikely
from flex_ident.estimation.kind_fit import KindFit, gravity_slope, refitted
from flex_ident.estimation.kind_gain import gain_of
from flex_ident.estimation.kind_priors import largest_moment
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit, Prior
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters import GRAVITY_KEYS, UNITS
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.terms import GRAVITY

PULLS = (-2.0, -1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 2.0)
"""Gravity's pulls that are tried, over the usual moment of a link of that inertia: of one that hangs, and one that
stands."""
HELD = 1e-5
"""Share of K by which it may leave the value at which it is held, one standard deviation."""
SOFTEST = 0.1
"""Share of its inertia that the link must keep for a pull to be tried."""
TOLD, FEWEST = 100.0, 5
"""Twice the log-likelihood below the best within which points say how rough a walk is, and as many as it takes. Set by
hand: the walks of two joints whose K came out 3 and 5 standard deviations off had gains that lie 4 and 9 off."""
BETTER = 1.0
"""Twice the log-likelihood from which a point of the walk is worth a fit with K free."""


def with_gravity_walked(problem: FitProblem, found: KindFit) -> KindFit:
    """The likeliest fit of an effort less gravity, with all that is nearly as likely along its valley in `open`, and
    with what a link of that inertia may weigh. A link encoder shows gravity to first order: there nothing is walked.
    """
    if problem.link is not None or not all(key in found.fit.free for key in ("K", "JL", *GRAVITY_KEYS)):
        return found
    usual = 0.5 * largest_moment(found.fit.values["JL"])
    known = _freed(problem, found.solver, found.fit, usual)
    if known is not None:
        found = replace(found, solver=known[0], fit=known[1])
    walk = _walked(problem, found.solver, found.fit, usual)
    if not walk:
        return found
    gains = [_gain(problem, found, there, usual) for there in walk]
    best = int(np.argmax(gains))
    if gains[best] > BETTER:
        free = _freed(problem, found.solver, walk[best][1], usual)
        if free is not None and (gain := _gain(problem, found, free, usual)) > max(BETTER, gains[best] - BETTER):
            found = replace(found, solver=free[0], fit=free[1])
            gains = [g - gain for g in gains]
    return replace(found, rival=np.zeros(len(found.fit.free)), open=_spread(problem, found.fit, walk, gains))


def _walked(problem: FitProblem, solver: SteadyFit, fit: Fit, usual: float) -> list[tuple[SteadyFit, Fit]]:
    """The fits with K held where each pull puts it."""
    values, here = fit.values, float(np.mean(problem.motion.position))
    slope = GRAVITY * gravity_slope(values, here)
    stiffness = values["K"] - slope
    across = values["MX"] * math.cos(here) + values["MY"] * math.sin(here)
    found: list[tuple[SteadyFit, Fit]] = []
    for pull in PULLS:
        k = GRAVITY * pull * usual
        ratio = (stiffness + 2.0 * k) / (stiffness + 2.0 * slope)
        if not (stiffness + 2.0 * k > SOFTEST * stiffness > 0.0 and ratio > 0.0):
            continue
        own = {"K": stiffness + k, "MX": across * math.cos(here) - pull * usual * math.sin(here)}
        own["MY"] = across * math.sin(here) + pull * usual * math.cos(here)
        own |= {key: ratio * values[key] for key in ("JL", "FV", "FS") if key in values}
        held = {"K": Prior(own["K"], HELD * own["K"], 0.0, math.inf)}
        try:
            found.append(_refitted(problem, solver, fit, values | Values(own), held, usual))
        except ExcitationError:
            continue
    return found


def _refitted(
    problem: FitProblem, solver: SteadyFit, fit: Fit, start: Values, held: dict[str, Prior], usual: float
) -> tuple[SteadyFit, Fit]:
    """The fit from there, with what a link may weigh known beforehand. Raises ExcitationError."""
    keys = [k for k in fit.free if k in UNITS]
    moments = {k: Prior(0.0, usual, -math.inf, math.inf) for k in GRAVITY_KEYS}
    return refitted(problem, solver, keys, start, moments={**moments, **held})


def _freed(problem: FitProblem, solver: SteadyFit, fit: Fit, usual: float) -> tuple[SteadyFit, Fit] | None:
    """The fit from a point of the walk with K free."""
    try:
        return _refitted(problem, solver, fit, fit.values, {}, usual)
    except ExcitationError:
        return None


def _gain(problem: FitProblem, found: KindFit, there: tuple[SteadyFit, Fit], usual: float) -> float:
    """Twice the log-likelihood that a fit gains over the one found, with what a link may weigh."""
    size = gain_of(problem, there[0], found.fit, there[1]).size
    return size + unlikely(found.fit.values, usual) - unlikely(there[1].values, usual)


def _roughness(at: Floats, gains: Floats) -> float:
    """How far the walk's gains (k,) at stiffnesses (k,) lie off a parabola, rms, at least one.

    Where friction comes to rest here and not there the fits of a walk end by chance in one or another of many bottoms:
    differences of that size say nothing.
    """
    near = gains > np.max(gains) - TOLD
    if near.sum() < FEWEST:
        return 1.0
    place = (at[near] - at[near].mean()) / max(float(np.ptp(at[near])), 1e-300)
    off = gains[near] - np.polyval(np.polyfit(place, gains[near], 2), place)
    return max(1.0, math.sqrt(float(off @ off) / (off.size - 3)))


def _spread(problem: FitProblem, fit: Fit, walk: list[tuple[SteadyFit, Fit]], gains: list[float]) -> Floats:
    """Second moments (p, p) about the fit of the points of the walk, each as probable as its likelihood times its
    share of the way; less by what of the probability lies within the fit's own standard deviation."""
    order = np.argsort([there.values["K"] for _, there in walk])
    at = np.array([walk[i][1].values["K"] for i in order])
    width = np.abs(np.gradient(at)) if at.size > 1 else np.zeros(at.size)
    sized = np.array([gains[i] for i in order])
    likely = width * np.exp(0.5 * np.clip(sized / _roughness(at, sized), -200.0, 20.0))
    own = math.sqrt(2.0 * math.pi) * min(uncertainty_of(fit, problem.rate_hz).std("K"), float(np.ptp(at)))
    apart = np.array([(fit.values | walk[i][1].values).vector(fit.free) for i in order]) - fit.values.vector(fit.free)
    weight = likely / max(float(likely.sum()), own, 1e-300)
    moments: Floats = np.einsum("i,ij,ik->jk", weight, apart, apart)
    return moments
