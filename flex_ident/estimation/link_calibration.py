"""What a link encoder's scale does to the parameters beyond what the fit believes to know of it."""

from __future__ import annotations

from flex_ident.estimation.thresholds import LINK_CALIBRATION
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.recording import Floats

SCALE = "link_scale"


def calibration_shift(known: Uncertainty) -> Floats | None:
    """What `LINK_CALIBRATION` of the link encoder's scale moves the free keys (p,) by; None where there is none.

    A fit over a wide motion finds the scale to a part in a million, which no encoder is right to from line to line. So
    the parameters are open by what they follow it by: their covariance with it over its variance.
    """
    if SCALE not in known.free or not known.std(SCALE) < float("inf"):
        return None
    i = known.free.index(SCALE)
    variance = known.covariance[i, i]
    if not variance > 0.0:
        return None
    follows: Floats = known.covariance[:, i] / variance
    return LINK_CALIBRATION * follows
