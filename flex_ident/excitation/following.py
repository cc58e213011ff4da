"""Whether a joint follows at all: a controller that is inactive or of other joints takes commands and does nothing."""

from __future__ import annotations

import math

LEAST_SHARE = 0.1
"""Share of the reference's way that the joint must move too."""
TOLD_BY = 0.5
"""Share of the reference's whole span after which that can be told."""


class Following:
    """The spans of reference and joint since a motion began; `whole` is the span, rad, that the reference will have."""

    def __init__(self, whole: float) -> None:
        self._whole = whole
        self._reference = (math.inf, -math.inf)
        self._joint = (math.inf, -math.inf)

    def fault(self, reference: float, joint: float) -> str:
        """What is wrong when the joint, rad, has not moved with the reference, rad; empty when nothing is."""
        self._reference = min(self._reference[0], reference), max(self._reference[1], reference)
        self._joint = min(self._joint[0], joint), max(self._joint[1], joint)
        wanted, moved = self._reference[1] - self._reference[0], self._joint[1] - self._joint[0]
        if wanted < TOLD_BY * self._whole or moved >= LEAST_SHARE * wanted:
            return ""
        return (
            f"the joint does not follow: it moved {moved:.2g} rad while the reference moved {wanted:.2g} rad: is the "
            "controller active, and does command.joints hold all of its joints?"
        )
