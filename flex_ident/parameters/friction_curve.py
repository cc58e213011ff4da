"""Friction over speed and direction, as a recording of a rigid joint shows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flex_ident.errors import DataError
from flex_ident.recording.recording import Floats

COVERED = 1.96
"""Standard deviations of a 95 % interval."""


@dataclass(frozen=True)
class FrictionCurve:
    """Friction torque (k,), N m, at speeds (k,), rad/s, that increase, and one standard deviation (k,) of each.

    Negative speeds are those of the other direction, with friction of the other sign. Straight between the speeds of
    one direction. A constant torque is not in it: friction is taken as alike in both directions at the slowest speeds.
    Raises DataError where the shapes or the speeds are none of these.
    """

    speed: Floats
    friction: Floats
    std: Floats

    def __post_init__(self) -> None:
        if not self.speed.shape == self.friction.shape == self.std.shape or self.speed.ndim != 1:
            raise DataError(f"a friction curve of shapes {self.speed.shape}, {self.friction.shape}, {self.std.shape}.")
        if not (np.diff(self.speed) > 0.0).all():
            raise DataError("the speeds of a friction curve do not increase.")

    @property
    def lower(self) -> Floats:
        """Lower end of the 95 % interval at each speed (k,), N m."""
        ends: Floats = self.friction - COVERED * self.std
        return ends

    @property
    def upper(self) -> Floats:
        """Upper end of the 95 % interval at each speed (k,), N m."""
        ends: Floats = self.friction + COVERED * self.std
        return ends
