"""How much of the torque that was recorded the joint had: drives that give way, and readings whose gain drifts."""

from __future__ import annotations

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

ACTING = (Term.TORQUE_LIMIT, Term.IRON_LOSS, Term.TORQUE_DROOP, Term.GAIN_RATE)


def delivered_torque(terms: Floats, recorded: Floats, velocity: Floats, time: Floats) -> Floats:
    """The torque (n,), N m, behind one as recorded, at the motor's `velocity` (n,), rad/s, `time` (n,), s, after the
    start; the same array where the terms say nothing else."""
    if not any(terms[term] != 0.0 for term in ACTING):
        return recorded
    torque = recorded / (1.0 + terms[Term.GAIN_RATE] * time)
    limit = float(terms[Term.TORQUE_LIMIT])
    if limit > 0.0:
        torque = np.clip(torque, -limit, limit)
    lost = terms[Term.IRON_LOSS] * torque**2 + terms[Term.TORQUE_DROOP] * velocity**2
    delivered: Floats = torque / (1.0 + lost)
    return delivered
