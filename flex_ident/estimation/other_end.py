"""Where a fit from another start ended that is as likely: what lies between the two ends is not determined."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.estimation.thresholds import APART
from flex_ident.judgement.rules import ESSENTIAL
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.likelihood.fit import Fit
from flex_ident.recording import Floats


@dataclass(frozen=True)
class OtherEnd:
    """The key that differs most between two ends, in its standard deviations, its value at either, and how the free
    values (p,) differ."""

    key: str
    here: float
    there: float
    shift: Floats


def other_end(fit: Fit, known: Uncertainty) -> OtherEnd | None:
    """Where the fit's rival lies; None where there is none, or where Jm, K and JL are the same there.

    Two ends in one valley are as likely and near: only what no parabola explains is apart.
    """
    if fit.rival is None:
        return None
    shift = np.array([fit.rival.get(k, fit.values[k]) - fit.values[k] for k in fit.free])
    off = {
        k: abs(float(shift[i])) / known.std(k)
        for i, k in enumerate(fit.free) if k in ESSENTIAL and 0.0 < known.std(k) < math.inf
    }  # fmt: skip
    key = max(off, key=lambda k: off[k], default="")
    if not key or not off[key] > APART:
        return None
    return OtherEnd(key, fit.values[key], fit.rival[key], shift)
