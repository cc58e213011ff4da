"""What else yields beside the joint's own spring, and a mode of the link above the band: a motor alone cannot tell."""

from __future__ import annotations

import math

from flex_ident.estimation.thresholds import UNSEEN_SHARE
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Code, Notice
from flex_ident.parameters.parameter import FAR_MODE
from flex_ident.recording import Floats
from flex_ident.screening.scoring import following_of
from flex_ident.simulation.terms import Term

PROBE = 1e-3
"""Share of the link's inertia of the probe: a spring that rings is not linear in more."""
STDS = 2.0
"""Standard deviations of K from which it is said by how much."""


def unseen_shift(solver: SteadyFit, fit: Fit) -> Floats | None:
    """What `UNSEEN_SHARE` of the link's inertia, swinging just above the band, would change in the free values (p,).

    None for a rigid joint, and where the model has a second mass or is free to have this one.
    """
    problem = solver.problem
    if problem.rigid or "K" not in fit.free or FAR_MODE in fit.free:
        return None
    if problem.terms(fit.values)[Term.SECOND_INERTIA] != 0.0:
        return None
    moved = solver.whitened_residual(fit.values | {FAR_MODE: PROBE}, fit.whitenings) - fit.residual
    shift: Floats = (following_of(fit) @ moved) * UNSEEN_SHARE / PROBE
    return shift


def rigid_link_notice(solver: SteadyFit, fit: Fit, known: Uncertainty) -> Notice | None:
    """That K is of all that yields behind the motor; by how much it moves when a small part of the link swings just
    above the band, where that is beyond its interval. None where `unseen_shift` has none.

    The elbow of an arm whose shoulder is twelve and forty times as stiff, seen from its motor, was 12 and 3.5 % softer
    than its own spring: that is what its mode is of.

    Freed in the fit instead, it took a tenth of the inertia of clean recordings for itself, and K was 12 standard
    deviations off (`bench/coverage.py`, seed 11, recording 29): from a motor alone the assumption is to be said.
    """
    shift = unseen_shift(solver, fit)
    if shift is None:
        return None
    follow, std = float(shift[fit.free.index("K")]), known.std("K")
    if not 0.0 < std < math.inf:
        return None
    sizes = {
        "share_percent": 100.0 * UNSEEN_SHARE, "moved_percent": 100.0 * follow / fit.values["K"],
        "moved_stds": abs(follow) / std,
    }  # fmt: skip
    case = "far" if abs(follow) > STDS * std else "yields"
    return Notice(Code.LINK_TAKEN_AS_RIGID, "K", sizes, {"case": case})
