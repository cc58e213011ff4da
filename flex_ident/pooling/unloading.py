"""What the link has by itself, of recordings that were made with a known mass on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flex_ident.pooling.members import MemberValues
from flex_ident.pooling.torque_scale import INERTIAS, Load, TorqueScale


def unloaded(
    given: MemberValues, loads: Sequence[Load], scale: TorqueScale, *, slides: bool, assumed: bool
) -> MemberValues:
    """The values that the link has without the loads, uncertain by the scale too.

    Where the scale is not known it is taken as 1 if that is `assumed`; else what a loaded recording says of the link
    is left out.
    """
    known = scale.per_unit is not None and scale.covariance is not None and scale.both is not None
    per_unit = scale.per_unit if known else np.array([1.0, 1.0, 0.0])
    spread = scale.covariance if known else np.zeros((3, 3))
    assert per_unit is not None
    assert spread is not None
    values, covariances = given.values.copy(), given.covariances.copy()
    index = {key: k for k, key in enumerate(given.keys)}
    for i, load in enumerate(loads):
        if load.mass == 0.0:
            continue
        mx, my = load.mass * load.x, load.mass * load.y
        parts = dict.fromkeys(INERTIAS, (load.mass if slides else load.inertia, 0.0, 0.0))
        if not slides:
            parts |= {"MX": (0.0, mx, -my), "MY": (0.0, my, mx)}
        own = [
            (index[key], np.array(part)) for key, part in parts.items() if key in index and given.there[i, index[key]]
        ]
        for k, part in own:
            values[i, k] -= float(part @ per_unit)
        for k, part in own:
            for j, other in own:
                covariances[i, k, j] += float(part @ spread @ other)
        if not known and not assumed:
            for k, part in own:
                if part.any():
                    values[i, k] = np.nan
                    covariances[i, k, :] = covariances[i, :, k] = 0.0
    return MemberValues(given.keys, values, covariances, given.systematic, given.sessions)
