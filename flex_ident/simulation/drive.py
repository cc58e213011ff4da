"""How much of the torque that was recorded the joint had: drives that give way."""

from __future__ import annotations

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

ACTING = (Term.TORQUE_LIMIT, Term.IRON_LOSS, Term.TORQUE_DROOP)


def delivered_torque(terms: Floats, recorded: Floats, velocity: Floats) -> Floats:
    """The torque (n,), N m, behind one as recorded, at a `velocity` (n,), rad/s; the same array where the terms
    say nothing else."""
    if not any(terms[term] != 0.0 for term in ACTING):
        return recorded
    torque = recorded
    limit = float(terms[Term.TORQUE_LIMIT])
    if limit > 0.0:
        torque = np.clip(torque, -limit, limit)
    lost = terms[Term.IRON_LOSS] * torque**2 + terms[Term.TORQUE_DROOP] * velocity**2
    delivered: Floats = torque / (1.0 + lost)
    return delivered
