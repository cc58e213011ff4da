"""What hangs on a joint, as the robot's description has it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Weight:
    """First moments `MX` and `MY`, kg m, as eq. 7 has them over the joint's own position, and the `inertia` about the
    joint's axis, kg m^2, of all that lies behind it.

    `assumed`: joints that bear on it whose positions nobody recorded, taken at zero; `moving`: those that moved, taken
    at their mean.
    """

    MX: float
    MY: float
    inertia: float
    assumed: tuple[str, ...] = ()
    moving: tuple[str, ...] = ()
