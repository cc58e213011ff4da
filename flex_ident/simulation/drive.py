"""What a drive that gives way does between the torque that it records and the one that the joint has."""

from __future__ import annotations

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

LEAST_ROOT = 1e-3
"""Smallest root of the saturation's quadratic: beyond it no current gives the torque, and the reading goes on smoothly
in proportion."""


def delivered_torque(terms: Floats, recorded: Floats) -> Floats:
    """The torque (n,), N m, behind one as recorded where the drive clips it; the same array where it does not."""
    limit = float(terms[Term.TORQUE_LIMIT])
    return np.clip(recorded, -limit, limit) if limit > 0.0 else recorded


def recorded_torque(terms: Floats, delivered: Floats, velocity: Floats) -> Floats:
    """What is recorded of a torque (n,), N m, that the joint has at a `velocity` (n,), rad/s.

    The inverse of delivered = recorded / (1 + iron loss recorded^2 + droop velocity^2), less the product of the two.
    It is applied to what is predicted: a recording that is divided loses noise as well, and gains likelihood by that.
    """
    recorded = delivered
    if terms[Term.TORQUE_DROOP] != 0.0:
        recorded = recorded * (1.0 + terms[Term.TORQUE_DROOP] * velocity**2)
    if terms[Term.IRON_LOSS] != 0.0:
        root = np.sqrt(np.maximum(1.0 - 4.0 * terms[Term.IRON_LOSS] * delivered**2, LEAST_ROOT))
        recorded = recorded * 2.0 / (1.0 + root)
    return recorded
