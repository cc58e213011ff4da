"""What a measurement chain does to the parameters beyond what the fit believes to know of it."""

from __future__ import annotations

import numpy as np

from flex_ident.estimation.thresholds import AVERAGING_KNOWN, LINK_CALIBRATION
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats

SCALE = "link_scale"


def with_chain_open(
    uncertainty: Uncertainty, known: Uncertainty, values: Values, sample_time: float
) -> Uncertainty:  # fmt: skip
    """The uncertainty with what the best knowledge there can be of the chain leaves open.

    Of a link encoder's scale, and of how the torque is averaged within a sample of `sample_time`, s. `known` is that of
    the fit by itself.
    """
    return uncertainty.beside(scale_shift(known)).beside(averaging_shift(known.free, values, sample_time))


def scale_shift(known: Uncertainty) -> Floats | None:
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


def averaging_shift(free: tuple[str, ...], values: Values, sample_time: float) -> Floats | None:
    """What `AVERAGING_KNOWN` of the torque's averaging moves the free keys (p,) by; None for a joint without a spring
    or a motor.

    Averaged torque lacks its second derivative; of the spring's that is K times the deflection's, which below the mode
    is a motor's inertia of K Ts^2: it is taken from the link, and from K as well, as the mode K / JL is well known.
    """
    if not all(key in free for key in ("Jm", "K", "JL")):
        return None
    inertia = AVERAGING_KNOWN * values["K"] * sample_time**2
    moved = {"Jm": inertia, "JL": -inertia, "K": -inertia * values["K"] / values["JL"]}
    return np.array([moved.get(key, 0.0) for key in free])
