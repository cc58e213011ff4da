"""Which recording disagrees with the others, more than they do with each other."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from scipy.stats import t

from flex_ident.pooling.combining import between
from flex_ident.pooling.members import MemberValues
from flex_ident.pooling.sessions import session_means, within_sessions
from flex_ident.pooling.thresholds import DISAGREES, FEWEST_TO_DISAGREE
from flex_ident.recording.recording import Floats


@dataclass(frozen=True)
class Disagreement:
    """Recording `index` lies `stds` from what the others predict of `key`; `chance` is that of the farthest of all
    recordings and parameters to lie as far."""

    index: int
    key: str
    stds: float
    chance: float


def disagreements(given: MemberValues, explained: Collection[str] = ()) -> tuple[Disagreement, ...]:
    """The recordings that disagree, the farthest first; parameters in `explained` scatter by a known condition.

    Each is compared with the mean and the scatter of those that are left without it; one that disagrees is taken out
    before the next is looked for, while two thirds are left.
    """
    found: list[Disagreement] = []
    left = list(range(given.values.shape[0]))
    fewest = max(FEWEST_TO_DISAGREE, int(np.ceil(2.0 * len(left) / 3.0)) + 1)
    keys = [key for key in given.keys if key not in explained]
    while len(left) >= fewest:
        candidates = [c for i in left for key in keys if (c := _compared(given, left, i, key)) is not None]
        if not candidates:
            break
        worst = min(candidates, key=lambda c: (c.chance, -c.stds))
        chance = min(1.0, worst.chance * len(candidates))
        if chance >= DISAGREES:
            break
        found.append(Disagreement(worst.index, worst.key, worst.stds, chance))
        left.remove(worst.index)
    return tuple(found)


def _compared(given: MemberValues, left: list[int], index: int, key: str) -> Disagreement | None:
    """One recording against the others by one parameter; None where fewer than three other sessions determine it."""
    k = given.keys.index(key)
    others = [i for i in left if i != index and given.there[i, k]]
    together = len(set(given.sessions)) == 1
    count = len(others) if together else len({given.sessions[i] for i in others})
    if not given.there[index, k] or count < FEWEST_TO_DISAGREE - 1:
        return None
    stds = distance(given, others, index, k)
    return Disagreement(index, key, stds, 2.0 * float(t.sf(stds, count - 1)))


def distance(given: MemberValues, others: list[int], index: int, k: int) -> float:
    """Standard deviations of recording `index` from what `others` predict of parameter `k`, their scatter in them.

    Others of one session count as one, but where all recordings are of one.
    """
    values = given.values[:, k]
    shared = float(np.min(given.systematic[[*others, index], k]))
    variance: Floats = np.maximum(given.covariances[:, k, k] - shared**2, 0.0)
    there, known = values[others], variance[others]
    sessions = [given.sessions[i] for i in others]
    within = 0.0
    if 1 < len(set(sessions)) < len(others):
        within = within_sessions(there, np.sqrt(known), np.unique(sessions, return_inverse=True)[1])
        there, stds, _ = session_means(there, np.sqrt(known), sessions)
        known = stds**2
    tau2 = between(there, known)
    weights = 1.0 / (known + tau2)
    mean = float(weights @ there / weights.sum())
    return float(abs(values[index] - mean) / np.sqrt(variance[index] + within + tau2 + 1.0 / weights.sum()))
