"""Which recordings are of one session: what a day does (temperature, mounting) they share, and it is no chance of each.

    x_i = mu + s_g + b_i + e_i      s_g of the session g, b_i of the recording, e_i what it states of itself

What lies between sessions is learnt from sessions, not from recordings: those of one become one value.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from flex_ident.pooling.thresholds import SESSION_S
from flex_ident.recording.recording import Floats

Sessions = tuple[int, ...]
FIRST_DATE_S = datetime(2000, 1, 1, tzinfo=UTC).timestamp()
"""A recording that begins before is stamped by a simulation's clock or one that counts from when it was switched on."""


def sessions_of(starts_s: Sequence[float]) -> Sessions:
    """The session of each recording, counted from 0 in the order of time, by when each began, s.

    One ends `SESSION_S` after its first recording began. Recordings whose time is no date are each one of its own.
    """
    found = [0] * len(starts_s)
    count, first = -1, -np.inf
    for i in sorted(range(len(starts_s)), key=lambda own: starts_s[own]):
        dated = starts_s[i] > FIRST_DATE_S
        if not dated or starts_s[i] - first > SESSION_S:
            count, first = count + 1, starts_s[i] if dated else -np.inf
        found[i] = count
    return tuple(found)


def session_means(values: Floats, stds: Floats, sessions: Sequence[int]) -> tuple[Floats, Floats, Floats]:
    """Mean (g) of the values (n,) of each session in the order of their numbers, its standard deviation (g), and the
    weight (n,) of each value in the mean of its session.

    What scatters within sessions beyond what values state (n,) is taken to be alike in all of them.
    """
    at = np.unique(np.asarray(sessions), return_inverse=True)[1]
    variance: Floats = stds**2 + within_sessions(values, stds, at)
    sums = np.bincount(at, 1.0 / variance)
    weights: Floats = 1.0 / variance / sums[at]
    means: Floats = np.bincount(at, weights * values).astype(float)
    return means, 1.0 / np.sqrt(sums), weights


def within_sessions(values: Floats, stds: Floats, at: NDArray[np.intp]) -> float:
    """The variance between recordings of one session beyond what each states, 0 where there is none or no repeat."""
    count = np.bincount(at)
    freedom = values.size - count.size
    if freedom == 0:
        return 0.0
    means = np.bincount(at, values) / count
    left = float(np.sum((values - means[at]) ** 2))
    stated = float(np.sum(stds**2 * (1.0 - 1.0 / count[at])))
    return max(0.0, left - stated) / freedom
