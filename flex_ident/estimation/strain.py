"""Whether a nuisance at the end of what it can be matters: what the joint would become if it went back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flex_ident.estimation.thresholds import IDLE_STRAIN, STRAIN, STRAIN_MOVES
from flex_ident.judgement.rules import ESSENTIAL
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.thresholds import PHYSICAL_LEAD_S
from flex_ident.screening.scoring import following_of

PHYSICAL = {"torque_averaging": 1.0 / 24.0, "reversal_lead": PHYSICAL_LEAD_S}
"""What is there at most, where that is known: a mean or a hold of the torque over a period, friction that leads."""


def material(fit: Fit, ends: Sequence[str], known: Uncertainty) -> tuple[str, ...]:
    """Of the nuisances at their `ends` those that stand in for something that bears on the joint.

    One whose return to what is physical moves Jm, K, JL and J by less than `STRAIN_MOVES` standard deviations is idle.
    Of the others nothing is known, and each counts.
    """
    return tuple(key for key in ends if _moves(fit, key, known) > STRAIN_MOVES)


def _moves(fit: Fit, key: str, known: Uncertainty) -> float:
    """By how many standard deviations an essential parameter follows when a nuisance is held at its physical end."""
    if key not in PHYSICAL or key not in fit.free:
        return float("inf")
    held = replace(fit, at_bound=tuple({*fit.at_bound, key}))
    back = np.sign(fit.values[key]) * PHYSICAL[key] - fit.values[key]
    follow = following_of(held) @ (fit.jacobian[:, fit.free.index(key)] * back)
    sizes = [abs(float(follow[i])) / max(known.std(k), 1e-300) for i, k in enumerate(fit.free) if k in ESSENTIAL]
    return max(sizes, default=float("inf"))


def strained_factor(ends: Sequence[str], matter: Sequence[str]) -> float:
    """The factor on every standard deviation where nuisances are at their ends."""
    return STRAIN if matter else IDLE_STRAIN if ends else 1.0
