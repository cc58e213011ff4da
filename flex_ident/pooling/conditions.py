"""Which condition the scatter between recordings follows, with false alarms controlled over all that were tried.

Each condition is tried on each parameter that scatters, by an F-test of a line (of a mean for each text). The least
chance of all counts, against what it is when the recordings' conditions change places at random (Westfall and Young,
Resampling-Based Multiple Testing, 1993): however many conditions are tried, one is named in 5 % of the sets at most
where none is at work.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as fisher

from flex_ident.pooling.combining import Pooled
from flex_ident.pooling.members import MemberValues
from flex_ident.pooling.thresholds import ALIKE, FEWEST_FOR_CONDITION, NAMED, PERMUTATIONS, SCATTERS
from flex_ident.recording.recording import Floats

Condition = float | str
Orders = NDArray[np.int_]


@dataclass(frozen=True)
class Cause:
    """A condition that a parameter's scatter follows: `share` of its variance, `slope` per unit where it is a number.

    `chance` is over all conditions and parameters; `alike` are conditions that these recordings do not tell from it.
    """

    key: str
    condition: str
    share: float
    slope: float | None
    chance: float
    alike: tuple[str, ...] = ()


def causes(
    given: MemberValues, found: Sequence[Pooled], conditions: Sequence[Mapping[str, Condition]], *, seed: int = 0
) -> tuple[Cause, ...]:
    """For each parameter that scatters beyond chance the condition that it follows, where one does."""
    designs = _designs(conditions)
    n = len(conditions)
    complete = [k for k in range(len(given.keys)) if given.there[:, k].all() and found[k].chance < SCATTERS]
    if n < FEWEST_FOR_CONDITION or not designs or not complete:
        return ()
    scattering = [(k, given.values[:, k]) for k in complete]
    orders = _orders(n, seed)
    least = np.ones(len(orders))
    here: dict[tuple[int, str], float] = {}
    for k, values in scattering:
        for name, design in designs.items():
            shares = shares_explained(values, design, orders)
            more = n - 1 - design.shape[1]
            odds = np.maximum(shares, 0.0) / np.maximum(1.0 - shares, 1e-15) * more / design.shape[1]
            chances = fisher.sf(odds, design.shape[1], more)
            least = np.minimum(least, chances)
            here[k, name] = float(chances[0])
    named = []
    for k, values in scattering:
        name = min(designs, key=lambda own: here[k, own])
        chance = float(np.mean(least <= here[k, name] * (1.0 + 1e-9)))
        if chance < NAMED:
            named.append(_cause(given.keys[k], name, values, designs, chance))
    return tuple(named)


def _cause(key: str, name: str, values: Floats, designs: Mapping[str, Floats], chance: float) -> Cause:
    design = designs[name]
    share = float(shares_explained(values, design, np.arange(values.size)[None])[0])
    slope = None
    if design.shape[1] == 1:
        x = design[:, 0] - design[:, 0].mean()
        slope = float(x @ values / (x @ x))
    alike = tuple(
        other for other, own in designs.items()
        if other != name and own.shape[1] == design.shape[1] == 1
        and abs(float(np.corrcoef(own[:, 0], design[:, 0])[0, 1])) > ALIKE
    )  # fmt: skip
    return Cause(key, name, share, slope, chance, alike)


def _designs(conditions: Sequence[Mapping[str, Condition]]) -> dict[str, Floats]:
    """Columns (n, c) of each condition that all recordings have and that differs between them."""
    designs: dict[str, Floats] = {}
    names = dict.fromkeys(name for own in conditions for name in own)
    for name in names:
        if not all(name in own for own in conditions):
            continue
        texts = [own[name] for own in conditions]
        if all(isinstance(x, (int, float)) and math.isfinite(x) for x in texts):
            column = np.array([float(x) for x in texts])
            spread = float(np.ptp(column))
            if spread > 1e-9 * float(np.max(np.abs(column))):
                designs[name] = column[:, None]
            continue
        kinds = sorted({str(x) for x in texts})
        if 1 < len(kinds) < len(conditions) - 1:
            designs[name] = np.array([[float(str(x) == kind) for kind in kinds[1:]] for x in texts])
    return designs


def _orders(n: int, seed: int) -> Orders:
    """Orders (m, n) of the recordings, the first as they are: all, or so many at random."""
    if math.factorial(n) <= PERMUTATIONS:
        return np.array(list(permutations(range(n))))
    rng = np.random.default_rng(seed)
    return np.array([np.arange(n), *(rng.permutation(n) for _ in range(PERMUTATIONS))])


def shares_explained(values: Floats, design: Floats, orders: Orders) -> Floats:
    """Share (m,) of the variance of `values` (n,) that a design (n, c) accounts for, the values in each order (m, n).

    All recordings weigh alike, so that each order is as likely as another where no condition is at work.
    """
    target = values - values.mean()
    basis, _ = np.linalg.qr(design - design.mean(axis=0))
    shares: Floats = np.sum((target[orders] @ basis) ** 2, axis=1) / max(float(target @ target), 1e-300)
    return shares
