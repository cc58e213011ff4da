"""Starts that owe nothing to the base fit: where the effect is large, the fit without it may be lost."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from flex_ident.effects.probe import Scales
from flex_ident.errors import ExcitationError
from flex_ident.estimation.start import delay_scanned_start, limit_scanned_start, spring_scanned_start
from flex_ident.gap.spring_start import dead_band_start
from flex_ident.likelihood.problem import FitProblem
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

FAR_OFF = 0.2
"""Residual over torque, rms, from which the base fit is not where a delay or a saturation should start from."""
BENT = 0.02
"""Likewise for a spring whose law is scanned."""
HARDENINGS = (-0.1, -0.03, 0.01, 0.03, 0.1, 0.3)
"""Cubic over linear part of the spring's torque at the rms deflection of the best linear spring."""
LEAST_FRICTION = 0.05
"""Share of the link's viscous friction that is left when damping takes its part over."""


def start_anew(effect: str, problem: FitProblem, values: Mapping[str, float], scales: Scales) -> dict[str, float]:
    """Values of all keys, the effect's among them, from which a fit with the effect may start as well; or none."""
    match effect:
        case "nonlinear_stiffness":
            return _bent(problem, values, scales.deflection)
        case "backlash":
            return _anew(values, dead_band_start(problem))
        case "joint_damping":
            return _unskewed(values)
        case "time_delay":
            return _delayed(problem, values)
        case "saturation":
            return _clipped(problem, values)
    return {}


def _torque_residual(problem: FitProblem, values: Mapping[str, float]) -> Floats:
    return problem.residuals(values)[0][problem.usable]


def _far_off(problem: FitProblem, values: Mapping[str, float]) -> bool:
    left = float(np.std(_torque_residual(problem, values)))
    return not problem.rigid and left >= FAR_OFF * float(np.std(problem.torque[problem.usable]))


def _delayed(problem: FitProblem, values: Mapping[str, float]) -> dict[str, float]:
    """A start that knows the torque's delay: a fit that had to do without one may be lost."""
    if not _far_off(problem, values):
        return {}
    try:
        delay, found = delay_scanned_start(problem)
    except ExcitationError:
        return {}
    return _anew(values, {**found, "time_delay.delay": delay})


def _clipped(problem: FitProblem, values: Mapping[str, float]) -> dict[str, float]:
    """A start that knows where the drive saturates, likewise."""
    if not _far_off(problem, values):
        return {}
    try:
        limit, found = limit_scanned_start(problem)
    except ExcitationError:
        return {}
    return _anew(values, {**found, "saturation.limit": limit})


def _unskewed(values: Mapping[str, float]) -> dict[str, float]:
    """A start with the damping that a skew of the encoders and the link's friction stood in for."""
    damping = -values.get("link_skew", 0.0) * values["K"]
    if damping <= 0.0:
        return {}
    friction = {k: max(v - damping, LEAST_FRICTION * v) for k, v in values.items() if k == "FV"}
    return {**values, **friction, "link_skew": 0.0, "joint_damping.damping": damping}


def _bent(problem: FitProblem, values: Mapping[str, float], bend: float) -> dict[str, float]:
    """A start that knows how the spring hardens or softens: the best linear spring has its resonance elsewhere."""
    if problem.rigid or float(np.std(_torque_residual(problem, values))) < BENT * float(np.std(problem.torque)):
        return {}

    def hardening(share: float) -> Callable[[float], Mapping[Term, float]]:
        return lambda square: {Term.CUBIC_STIFFNESS: share * square / bend**2}

    try:
        which, inertia, found = spring_scanned_start(problem, [hardening(share) for share in HARDENINGS])
    except ExcitationError:
        return {}
    square = found["K"] / inertia
    return _anew(values, {**found, "nonlinear_stiffness.cubic": HARDENINGS[which] * square / bend**2 * inertia})


def _anew(values: Mapping[str, float], found: Mapping[str, float]) -> dict[str, float]:
    """The keys of a model as found without it, measurement keys at zero, and those of the effect."""
    if not found:
        return {}
    own = {k: v for k, v in found.items() if "." in k}
    return {**{k: found.get(k, v if "." in k else 0.0) for k, v in values.items()}, **own}
