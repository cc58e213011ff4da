"""What a measurement chain does to the parameters beyond what the fit believes to know of it."""

from __future__ import annotations

from flex_ident.estimation.thresholds import AVERAGING_KNOWN, LINK_CALIBRATION
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.recording import Floats

BEST_KNOWN = {"link_scale": LINK_CALIBRATION, "torque_averaging": AVERAGING_KNOWN}
"""Nuisances, and the standard deviation below which no fit knows them."""


def with_chain_open(uncertainty: Uncertainty, known: Uncertainty) -> Uncertainty:
    """The uncertainty with what the best knowledge there can be of the chain leaves open.

    A fit finds the scale of a link encoder to a part in a million, and the shape of the torque within a sample to a
    hundredth of one. No encoder is right to the first, and no motion between samples is known to the second. So the
    parameters are open by what they follow either by: their covariance with it over its variance, as `known` has them.
    """
    for key, least in BEST_KNOWN.items():
        shift = _shift(known, key, least)
        if shift is not None:
            uncertainty = uncertainty.beside(shift)
    return uncertainty


def _shift(known: Uncertainty, key: str, least: float) -> Floats | None:
    """What `least` of a nuisance moves the free keys (p,) by; None where it is not free, not known or at its bound."""
    if key not in known.free or not known.std(key) < float("inf"):
        return None
    i = known.free.index(key)
    variance = known.covariance[i, i]
    if not variance > 0.0:
        return None
    follows: Floats = known.covariance[:, i] / variance
    return least * follows
