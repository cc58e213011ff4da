"""What a measurement chain adds to a recording, estimated beside the joint: delays, averaging, the encoder's zero."""

from __future__ import annotations

import numpy as np

from flex_ident.estimation.fit import Prior
from flex_ident.estimation.problem import FitProblem


def measurement_priors(problem: FitProblem, *, delay_samples: float = 3.0) -> dict[str, Prior]:
    """Priors of the measurement keys that matter for this problem.

    Torque may be logged early or late by up to `delay_samples` periods, as a mean over a period or as a held
    command (kappa = ±1/24); the link encoder may be skewed likewise and has a zero of its own.
    """
    ts = problem.recording.sample_time
    limit = delay_samples * ts
    priors = {
        "torque_delay": Prior(0.0, ts, -limit, limit),
        "torque_averaging": Prior(0.0, 1.0 / 24.0, -0.25, 0.25),
    }
    if not problem.rigid:
        # The link starts somewhere in the band of its static friction; the trimmed start forgets most of it.
        spread, widest = 0.05 * float(np.ptp(problem.motion.position)) + 1e-9, 20.0
        if problem.link is not None:
            moved = problem.motion.position[:: problem.decimation] - problem.link
            spread, widest = float(np.std(moved[problem.usable])) + 1e-9, 4.0
        priors["initial_deflection"] = Prior(0.0, spread, -widest * spread, widest * spread)
    if problem.link is not None:
        reach = 10.0 * float(np.ptp(problem.motion.position)) + 10.0
        priors["link_skew"] = Prior(0.0, ts, -limit, limit)
        priors["link_zero"] = Prior(0.0, reach, -10.0 * reach, 10.0 * reach)
    return priors
