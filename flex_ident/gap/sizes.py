"""How large the gap is: of the torque, and of the link's position where that was recorded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.remainder import counted
from flex_ident.likelihood.thresholds import OWN_ERROR_OF_LINK
from flex_ident.parameters.values import Values


@dataclass(frozen=True)
class GapSize:
    """Measured minus simulated torque, N m rms, and link position, rad rms; None without a link encoder.

    `deflection`: of the spring, rad, standard deviation.
    """

    torque: float
    link: float | None = None
    deflection: float = 0.0

    @property
    def of_link(self) -> float | None:
        """The link's part as far as it is more than the method's own error; None where it is not."""
        return self.link if self.link is not None and self.link > OWN_ERROR_OF_LINK * self.deflection else None

    def falls_from(self, before: GapSize) -> bool:
        """Whether this is the smaller gap, of both signals together where both were recorded.

        What is no more of the link's position before than the method's own error does not count. The logarithm of each
        counts alike, as in the likelihood of white noise of unknown size. That the torque's gap does not grow over the
        whole recording, `gap.objections` has seen to.
        """
        if self.link is None or before.of_link is None:
            return self.torque < before.torque
        return self.torque * self.link < before.torque * before.of_link

    def numbers(self, name: str) -> dict[str, float]:
        """The gap for a reason: `name`, N m, and `name`_link_mrad where the link's position was recorded."""
        return {name: self.torque, **({} if self.link is None else {f"{name}_link_mrad": 1e3 * self.link})}


def gap_size(problem: FitProblem, values: Values, held: NDArray[np.bool_]) -> GapSize:
    """The gap on the rows `held` (m,) as far as they count: not where the motor sticks."""
    rows = counted(problem, held)
    torque, *link = (math.sqrt(float(np.mean(residual[rows] ** 2))) for residual in problem.residuals(values))
    if not link or problem.link is None:
        return GapSize(torque)
    deflection = problem.motion.position[:: problem.decimation] - problem.link
    return GapSize(torque, link[0], float(np.std(deflection[rows])))
