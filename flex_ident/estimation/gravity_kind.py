"""Whether the effort holds gravity or is less what the controller adds: found, or open with what that would move."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.estimation.kind_fit import KindFit, gravity_slope, refitted
from flex_ident.estimation.kind_gain import Gain, gain_of, linear_gain, shown_moment
from flex_ident.estimation.kind_priors import largest_moment, removed_prior
from flex_ident.estimation.thresholds import CLEARLY, FAR, HEAVIEST, HEAVIEST_BY_FAR, MOST_WITH_LINK, SEEN, SHOWN
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit, Prior
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.remainder import remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Code, Notice
from flex_ident.parameters import GRAVITY_KEYS, UNITS
from flex_ident.parameters.effort_kinds import GRAVITY_COMPENSATED, GRAVITY_REMOVED, MOTOR
from flex_ident.parameters.values import Values
from flex_ident.simulation.terms import GRAVITY

GRAVITY_SIZES = (0.0, 0.003, 0.01, 0.03, 0.1)
"""First moments times g that are tried, over the stiffness of the joint."""
GRAVITY_ANGLES = 8
LINK_SCALE = "link_scale"


def gravity_compensated(problem: FitProblem, solver: SteadyFit, fit: Fit) -> KindFit:
    """The better of the fits with and without gravity in the effort, or the latter and how far the other is off."""
    motor = KindFit(MOTOR, solver, fit)
    if not all(k in fit.free for k in GRAVITY_KEYS):
        return motor
    usual = 0.5 * largest_moment(fit.values["JL"])
    # Over a wide range the effort of a controller that adds gravity shows a little of it, to second order in its
    # stiffness: a first-order step from there says nothing.
    shows = shown_moment(problem, fit) > SHOWN * usual
    # Nor does it where the encoder's scale, as far from 1 as it may be, stands for what the effort does not hold.
    strained = LINK_SCALE in fit.at_bound
    if shows and not strained and linear_gain(problem, solver, fit) < -FAR:
        return motor
    keys = [k for k in fit.free if k in UNITS]
    moments = {k: Prior(0.0, usual, -math.inf, math.inf) for k in GRAVITY_KEYS}
    if problem.link is not None:  # it shows how much of the link's gravity the effort holds
        moments[GRAVITY_REMOVED] = removed_prior()
    tried: list[tuple[Gain, SteadyFit, Fit]] = []
    for start in _gravity_starts(problem, solver, fit, usual):
        try:
            own, found = refitted(problem, solver, keys, start, moments=moments)
        except ExcitationError:
            continue
        gain = gain_of(problem, own, fit, found)
        likelier = unlikely(fit.values, usual) - unlikely(found.values, usual)
        tried.append((replace(gain, size=gain.size + likelier), own, found))
    tried.sort(key=lambda one: -one[0].size)
    if not tried or tried[0][0].size < -CLEARLY:
        return motor
    gain, own, found = tried[0]
    if gain.size > CLEARLY:  # it may be the model to report: fitted as carefully as the other
        try:
            again = refitted(problem, solver, keys, found.values, rough=True, moments=moments)
        except ExcitationError:
            again = own, found
        step = gain_of(problem, own, found, again[1]).size  # of the two at one noise
        if step + unlikely(found.values, usual) - unlikely(again[1].values, usual) > 0.0:
            better = gain_of(problem, own, fit, again[1])
            likelier = unlikely(fit.values, usual) - unlikely(again[1].values, usual)
            gain, own, found = replace(better, size=better.size + likelier), *again
            tried[0] = (gain, own, found)
    alike = [f for g, _, f in tried if g.size > gain.size - CLEARLY]
    left = remainder(own, found)
    known_noise = left.evidence != "none" and not left.structured(left.gap)
    explains = problem.link is not None and gain.share > MOST_WITH_LINK and known_noise
    heaviest = HEAVIEST_BY_FAR if gain.size > FAR else HEAVIEST
    likely = math.hypot(*(found.values[k] for k in GRAVITY_KEYS)) < heaviest * usual
    known = uncertainty_of(found, problem.rate_hz)
    alone = all(abs(f.values[k] - found.values[k]) < SEEN * known.std(k) for f in alike for k in keys)
    if gain.size > CLEARLY and likely and explains and alone and _gravity_sigmas(found, problem.rate_hz) > SEEN:
        notice = Notice(Code.EFFORT_GRAVITY_COMPENSATED, "motor_torque", {"gain": gain.size}, {"case": "found"})
        kind = KindFit(GRAVITY_COMPENSATED, own, found, (notice,))
        if gain.size > FAR:
            return kind
        # An eccentric link encoder has passed for it: the other fit stays in the uncertainty.
        other = (found.values | fit.values).vector(found.free) - found.values.vector(found.free)
        size = len(found.free)
        return replace(kind, rival=other, open=np.zeros((size, size)))
    rivals = [f.values.vector(fit.free) - fit.values.vector(fit.free) for f in alike]
    moved = max(rivals, key=lambda r: abs(float(r[fit.free.index("K")])))
    both = [found.free.index(k) for k in fit.free]
    return replace(motor, rival=moved, open=known.covariance[np.ix_(both, both)])


def unlikely(values: Values, usual: float) -> float:
    """Twice the negative log-likelihood, before any data, of first moments of which `usual`, kg m, is one deviation."""
    return sum((values.get(k, 0.0) / usual) ** 2 for k in GRAVITY_KEYS)


def _gravity_starts(problem: FitProblem, solver: SteadyFit, fit: Fit, usual: float) -> list[Values]:
    """Where fits of an effort without gravity start: the best of gravities of several sizes and directions, of which
    `usual` is one standard deviation.

    Such a torque is, to first order in gravity's stiffness k over K, that of a joint without gravity of a stiffness
    K - k and a link inertia smaller in the ratio of the squares: so the fit with the motor's torque lies in a valley
    along which gravity is open, with K and JL following. Only what is of second order in k, or a link encoder, tells.
    """
    values, here = fit.values, float(np.mean(problem.motion.position))
    if LINK_SCALE in fit.at_bound:
        values = values | {LINK_SCALE: 0.0}
    many = [values | {GRAVITY_REMOVED: 1.0}]
    for size in GRAVITY_SIZES:
        for angle in np.arange(GRAVITY_ANGLES) * 2.0 * math.pi / GRAVITY_ANGLES:
            moment = size * values["K"] / GRAVITY
            slope = -GRAVITY * moment * math.sin(here - angle)
            stiffness = values["K"] + slope
            ratio = (stiffness + slope) / values["K"]
            own = {"K": stiffness, "MX": moment * math.cos(angle), "MY": moment * math.sin(angle), "offset": 0.0}
            own |= {k: ratio * values[k] for k in ("JL", "FV", "FS") if k in values}
            many.append(values | own | {GRAVITY_REMOVED: 1.0})
    rests = solver.whitened_residuals(many, fit.whitenings)
    costs = [
        float(r @ r) + unlikely(v, usual) if np.isfinite(r).all() else math.inf
        for r, v in zip(rests, many, strict=True)
    ]
    order = sorted(range(len(many)), key=lambda i: costs[i])
    first = many[order[0]]
    # The next that lies elsewhere: of gravity that pulls the other way, if there is one.
    apart = next(
        (many[i] for i in order[1:] if gravity_slope(many[i], here) * gravity_slope(first, here) < 0.0), many[order[1]]
    )
    return [first, apart]


def _gravity_sigmas(fit: Fit, rate_hz: float) -> float:
    known = uncertainty_of(fit, rate_hz)
    ratios = [abs(fit.values[k]) / known.std(k) for k in GRAVITY_KEYS if known.std(k) > 0.0]
    return max(ratios, default=0.0)
