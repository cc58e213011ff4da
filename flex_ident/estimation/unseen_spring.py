"""What a spring that a rigid joint's recording does not show would still do to its inertia.

    (Jm + JL / (1 - (w / w0)^2)) w^2  =  (Jm + JL) w^2 + (JL / w0^2) w^4 + ...        w0^2 = K / JL

To first order a spring adds the fourth derivative of the position to the torque; without it the inertia is too large.
"""

from __future__ import annotations

import numpy as np

from flex_ident.filtering.spectral import Complexes
from flex_ident.likelihood.comparison import correlation_factor
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.recording import Floats


def spring_shift(solver: SteadyFit, fit: Fit) -> Floats | None:
    """What a compliance, at its most likely size, would change in the free values (p,) of a rigid joint.

    Less of what is no larger than chance would make it. None for another joint, and where the most likely compliance is
    less than none.
    """
    problem = solver.problem
    if not problem.rigid:
        return None

    def twice(omega: Floats) -> Complexes:
        return np.asarray(omega**2, complex)

    column = solver.whitened((-problem.reduced_through(problem.motion.acceleration, twice),), fit.whitenings)
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    known = np.sqrt(np.diag(fit.prior_information))[inside]
    rows = np.vstack(
        (np.column_stack((fit.jacobian[:, inside], column)), np.column_stack((np.diag(known), 0.0 * known)))
    )
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0.0] = 1.0
    target = np.concatenate((-fit.residual, np.zeros(len(inside))))
    solution = np.linalg.lstsq(rows / scale, target, rcond=1e-9)[0] / scale
    if not solution[-1] > 0.0:
        return None
    gain = float(target @ (rows @ solution)) / correlation_factor(fit)
    shift = np.zeros(len(fit.free))
    shift[inside] = gain / (1.0 + gain) * solution[:-1]
    return shift
