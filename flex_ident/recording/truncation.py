"""Efforts cut toward zero to whole steps, as a cast to a whole number does it in a drive's firmware.

Rounding to the nearest step leaves an effort true on average. Cutting takes half a step from the size of everything but
zero, which looks like less friction and less weight. It shows in how long the effort stays at zero when it passes
through: two steps wide instead of one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording.recording import Floats

ON_GRID = 0.01
"""Share of a step by which values may miss the grid; single precision misses it by less up to a hundred thousand."""
LARGEST_COUNT = 100_000
REACHES = (2, 5, 20)
"""Steps to each side of zero that its neighbourhood is made of: one that shows the cut is enough."""
FEWEST_PASSES = 12
SURE = 3.5
"""Standard deviations by which the time at zero must exceed that of a step. With 3, six of 1190 efforts that were
rounded passed for cut (`bench/plants`, seeds 907 and 919); with 4 none of 600, and fewer of those that were cut. With
3.5 two of 900 of an unseen seed (929) did, and 273 of 450 that were cut were found."""
NEARER = 2.0
"""How many times further it must be from one step than from two."""
EVEN = 0.25
"""Share by which the steps next to zero may differ from those further out: else zero differs for another reason."""


class _Ratio(NamedTuple):
    value: float
    std: float


class EffortGrid(NamedTuple):
    """The steps in which an effort comes, and whether it was cut toward zero to them; None: that does not show."""

    step: float
    cut: bool | None


def effort_grid(values: Floats) -> EffortGrid | None:
    """The grid on which an effort (n,) lies; None where it lies on none."""
    step = grid_step(values)
    if step == 0.0:
        return None
    counts = np.rint(values / step).astype(np.int64)
    around = [found for reach in REACHES if (found := _around_zero(counts, reach)) is not None]
    if any(_is_cut(*one) for one in around):
        return EffortGrid(step, cut=True)
    return EffortGrid(step, cut=False if any(_is_rounded(*one) for one in around) else None)


def untruncated(values: Floats, step: float) -> Floats:
    """The values (n,) with half a step put back, which is what was cut off on average; zero stays zero."""
    found: Floats = values + 0.5 * step * np.sign(values)
    return found


def grid_step(values: Floats) -> float:
    """The step of a grid through zero on which all values (n,) lie; 0 where there is none."""
    apart = np.diff(np.unique(values))
    largest = float(np.max(np.abs(values), initial=0.0))
    apart = apart[apart > largest / LARGEST_COUNT]
    if apart.size == 0:
        return 0.0
    least = float(np.min(apart))
    step = float(np.median(apart[apart < 1.5 * least]))
    whole = np.rint(values / step)
    top = float(np.max(np.abs(whole)))
    if top == 0.0:
        return 0.0
    step = float(values @ whole / (whole @ whole))
    return step if float(np.max(np.abs(values / step - np.rint(values / step)))) < ON_GRID else 0.0


def _around_zero(counts: NDArray[np.int64], reach: int) -> tuple[_Ratio, _Ratio] | None:
    """How long the effort is at zero, and at the steps beside it, in its passes through zero: each over what it is at a
    step of the neighbourhood on average. None where the passes are too few to tell.
    """
    passes = _passes(counts, reach)
    if len(passes) < FEWEST_PASSES:
        return None
    size = np.abs(np.concatenate([counts[a:b] for a, b in passes]))
    own = np.repeat(np.arange(len(passes)), [b - a for a, b in passes])
    at_zero, beside, around = (
        np.bincount(own[where], minlength=len(passes)).astype(float) for where in (size == 0, size == 1, size > 0)
    )
    length = at_zero + around
    weight = 1.0 / np.maximum(length, np.median(length))  # a few slow passes would be most of all samples
    near = weight * around / (2.0 * reach)
    zero = _ratio(weight * at_zero, near)
    return zero, _ratio(0.5 * weight * beside, near)


def _is_cut(zero: _Ratio, beside: _Ratio) -> bool:
    """Whether the effort is at zero for two steps, in a neighbourhood that is even otherwise."""
    longer = zero.value - 1.0 > max(SURE * zero.std, NEARER * abs(zero.value - 2.0))
    return longer and _is_even(beside)


def _is_rounded(zero: _Ratio, beside: _Ratio) -> bool:
    """Whether it is there for one step, likewise."""
    shorter = 2.0 - zero.value > max(SURE * zero.std, NEARER * abs(zero.value - 1.0))
    return shorter and _is_even(beside)


def _is_even(beside: _Ratio) -> bool:
    return abs(beside.value - 1.0) < EVEN + 3.0 * beside.std


def _passes(counts: NDArray[np.int64], reach: int) -> list[tuple[int, int]]:
    """Stretches of samples in which an effort goes from beyond `reach` steps to beyond them at the other side."""
    beyond = np.flatnonzero(np.abs(counts) > reach)
    sign = np.sign(counts[beyond])
    through = (np.diff(beyond) > 1) & (np.diff(sign) != 0)
    return [(int(a) + 1, int(b)) for a, b in zip(beyond[:-1][through], beyond[1:][through], strict=True)]


def _ratio(one: Floats, other: Floats) -> _Ratio:
    """The ratio of two sums over passes; its standard deviation by leaving out each pass in turn."""
    total, of = float(np.sum(one)), float(np.sum(other))
    if of <= 0.0 or np.any(of - other <= 0.0):
        return _Ratio(0.0, np.inf)
    without = (total - one) / (of - other)
    count = one.size
    return _Ratio(total / of, float(np.sqrt((count - 1) / count * np.sum((without - np.mean(without)) ** 2))))
