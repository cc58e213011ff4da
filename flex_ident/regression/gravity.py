"""Whether a rigid joint's recording shows gravity: its two columns are kept only where they are gravity's doing."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording import Floats
from flex_ident.regression.least_squares import LinearFit, least_squares
from flex_ident.regression.thresholds import BIC_GAIN, CANCELLED, CERTAIN

KEYS = ("MX", "MY")


def shows_gravity(matrix: Floats, target: Floats, names: tuple[str, ...], held: NDArray[np.bool_], lag: int) -> bool:
    """Whether the columns MX and MY of `matrix` (r, p) belong into the model of `target` (r,).

    The BIC must fall, counted in samples that are independent as far as the residual tells; the rows `held` (r,) must
    be predicted no worse by a fit that did not see them; and the constant torque must not cancel gravity's. Over a
    short travel constant, MX and MY are any parabola in position, which friction that varies along the travel also
    fits: it gives a large first moment and, against it, as large an offset.
    """
    plain = [i for i, name in enumerate(names) if name not in KEYS]
    few = tuple(names[i] for i in plain)
    without, full = least_squares(matrix[:, plain], target, few, lag=lag), least_squares(matrix, target, names, lag=lag)
    count = target.size / max(1.0, correlation_samples(full.residual, lag))
    left, least = float(without.residual @ without.residual), float(full.residual @ full.residual)
    if left <= 0.0 or count * math.log(left / max(least, 1e-12 * left)) - len(KEYS) * math.log(count) < BIC_GAIN:
        return False
    seen = ~held
    unseen = [
        float(np.linalg.norm(target[held] - m[held] @ least_squares(m[seen], target[seen], n).values))
        for m, n in ((matrix[:, plain], few), (matrix, names))
    ]
    return unseen[1] <= unseen[0] and not _cancelled(matrix, full)


def correlation_samples(residual: Floats, lag: int) -> float:
    """Samples of a residual (r,) that count as one: 1 + 2 sum of its autocorrelation up to `lag`, tapered."""
    e = residual - residual.mean()
    power = float(e @ e)
    if lag < 1 or power == 0.0:
        return 1.0
    return 1.0 + 2.0 * sum((1.0 - k / (lag + 1.0)) * float(e[k:] @ e[:-k]) / power for k in range(1, lag + 1))


def _cancelled(matrix: Floats, fit: LinearFit) -> bool:
    gravity = sum(fit.value(key) * float(np.mean(matrix[:, fit.names.index(key)])) for key in KEYS)
    offset, std = fit.value("offset"), fit.std("offset")
    return bool(abs(offset) > CERTAIN * std and abs(gravity + offset) < CANCELLED * abs(gravity))
