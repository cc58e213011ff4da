"""How large the gap is: of the torque, and of the link's position where that was recorded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.remainder import counted
from flex_ident.parameters.values import Values


@dataclass(frozen=True)
class GapSize:
    """Measured minus simulated torque, N m rms, and link position, rad rms; None without a link encoder."""

    torque: float
    link: float | None = None

    def falls_from(self, before: GapSize) -> bool:
        """Whether this is the smaller gap, of both signals together where both were recorded.

        The logarithm of each counts alike, as in the likelihood of white noise of unknown size. That the torque's gap
        does not grow over the whole recording, `gap.objections` has seen to.
        """
        if self.link is None or before.link is None:
            return self.torque < before.torque
        return self.torque * self.link < before.torque * before.link

    @property
    def shown(self) -> str:
        """The gap in words, its link part in mrad."""
        return f"{self.torque:.3g} N m" + ("" if self.link is None else f", {1e3 * self.link:.3g} mrad")


def gap_size(problem: FitProblem, values: Values, held: NDArray[np.bool_]) -> GapSize:
    """The gap on the rows `held` (m,) as far as they count: not where the motor sticks."""
    rows = counted(problem, held)
    torque, *link = (math.sqrt(float(np.mean(residual[rows] ** 2))) for residual in problem.residuals(values))
    return GapSize(torque, link[0] if link else None)
