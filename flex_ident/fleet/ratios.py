"""Ratios of parameters that one result knows better than the parameters themselves, by their covariance.

What moves the effort's scale from one recording to the next (temperature, calibration) moves stiffness and inertias by
one factor and leaves their ratios; and an error of K that goes with one of JL leaves the locked-motor frequency.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

LOCKED, SHARES = "K/JL", "JL/Jm"
"""The square of the locked-motor frequency, rad^2/s^2, and the link's inertia over the motor's."""
RATIOS = {LOCKED: ("K", "JL", "1/s^2"), SHARES: ("JL", "Jm", "")}


def ratios(
    known: Mapping[str, tuple[float, float, str]], covariance: str | None
) -> dict[str, tuple[float, float, str]]:
    """Value, standard deviation and unit of each ratio that positive values and their covariance (JSON) give."""
    content: Mapping[str, Any] | None = json.loads(covariance) if covariance else None
    if content is None:
        return {}
    keys, matrix = list(content["keys"]), content["matrix"]
    found = {}
    for name, (over, under, unit) in RATIOS.items():
        if not all(key in known and key in keys and known[key][0] > 0.0 for key in (over, under)):
            continue
        (a, *_), (b, *_), i, j = known[over], known[under], keys.index(over), keys.index(under)
        relative = matrix[i][i] / a**2 + matrix[j][j] / b**2 - 2.0 * matrix[i][j] / (a * b)
        if relative > 0.0:
            found[name] = (a / b, a / b * math.sqrt(relative), unit)
    return found
