"""What K and JL would be where the torque that grows with the position acts on the motor, not on the link.

    Jm s^2 + K (JL s^2 + k) / (JL s^2 + k + K)   =   Jm s^2 + k' + K' JL' s^2 / (JL' s^2 + K')

with k' = K k / (K + k), K' = K^2 / (K + k), JL' = JL (K / (K + k))^2: from the motor alone the two are one, unless the
slope k bends over the motion as that of gravity does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from flex_ident.estimation.thresholds import NOTED_SHARE, NOTED_STDS
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.notices import Code, Notice
from flex_ident.parameters import GRAVITY_KEYS
from flex_ident.simulation.terms import GRAVITY


def motor_side_notice(problem: FitProblem, fit: Fit, known: Uncertainty, unseen: Mapping[str, float]) -> Notice | None:
    """By how much JL and K would be off where a spring on the motor pulls as gravity seems to.

    None where that is within the intervals, with a link encoder, for a model without motor or spring, and where the
    motion shows that it is gravity: where springs beside it, `unseen`, leave the first moments known.
    """
    values = fit.values
    if problem.rigid or problem.link is not None or not {"Jm", "K", "JL"} <= set(fit.free):
        return None
    position = problem.motion.position
    mx, my = (values.get(key, 0.0) for key in GRAVITY_KEYS)
    key = max(GRAVITY_KEYS, key=lambda k: abs(values.get(k, 0.0)))
    if math.hypot(unseen.get(key, 0.0), known.std(key)) <= NOTED_SHARE * abs(values.get(key, 0.0)):
        return None
    slope = GRAVITY * float(np.mean(my * np.cos(position) - mx * np.sin(position)))
    softer = values["K"] / (values["K"] + slope) if values["K"] + slope > 0.0 else 1.0
    moved, std = abs(softer**2 - 1.0), known.std("JL") / values["JL"]
    if not moved > max(NOTED_STDS * std, NOTED_SHARE):
        return None
    sizes = {
        "moved_percent": 100.0 * (softer**2 - 1.0),
        "moved_stds": moved / std,
        "stiffness_percent": 100.0 * (softer - 1.0),
    }
    return Notice(Code.SLOPE_TAKEN_ON_LINK, "JL", sizes)
