"""Positions that jump and go on from there: an encoder that wraps at its seam, or was set anew."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from flex_ident.recording.noise import resolution
from flex_ident.recording.recording import Floats

NEAR = 9
"""Steps around one of which the median says how the joint moves there."""
WIDE = 33
"""Steps over which it is seen how much they scatter."""
SCATTER, CHANGES = 12.0, 6.0
"""How far a step must lie off the median around it, in the scatter around it and in its own usual size there."""
SMALLEST_SHARE = 0.01
"""The same in the range that the joint moves in any case."""
OWN_SHARE = 0.5
"""Share of what a step lies off the median that the steps right beside it must not explain: a joint at rest that is
pushed between two rests lies as far off, and moves as smoothly (a PRBS at 250 Hz: 0.05)."""
WANDER = 0.99
"""Quantile of the speed, and of what time steps differ from the usual one by: so far it moves while stamps wander."""
GAP_PERIODS = 3.0
"""Time steps, in periods, from which one cannot say what happened in between but by the size of other jumps."""
MOST_SHARE = 0.08
"""Share of the samples from which jumps are the signal."""
FEWEST_MOVING = 8
"""Steps around one, other than zero, by which it is seen how fast the joint moves there."""
CATCH_UP = 2.0
"""Of what the joint moves in the time that a value was held: so far the step after it is no jump."""
ALIKE = 0.1
"""Differences of jumps, in their size, up to which they are turns of one seam."""
MOSTLY = 0.8
"""Share of the jumps that must be alike; beside another jump, the size of one cannot be seen well."""
EXACT = 0.003
"""Difference from a turn, 2 pi over the gear, up to which a seam is that turn."""


@dataclass(frozen=True)
class Jumps:
    """Positions made continuous; how many jumps there were, their size, and whether they are turns of one seam."""

    values: Floats
    count: int
    size: float
    seam: bool


def continued(time: Floats, values: Floats, turn: float) -> Jumps:
    """Positions (n,) without the jumps after which they go on as before. `turn` is that of the encoder, rad.

    A jump is a single step that lies far off the steps before and behind it: no joint has a speed for one sample only.
    Where stamps wander, it is also further than the joint moves in the time that they wander by.
    """
    steps = np.diff(values)
    none = Jumps(values, 0, 0.0, False)
    if steps.size < WIDE:
        return none
    dt = np.diff(time)
    usual = float(np.median(dt))
    speed = ndimage.median_filter(steps / dt, NEAR, mode="mirror")
    off = steps - speed * dt
    scatter = ndimage.median_filter(np.abs(off), WIDE, mode="mirror")
    size = ndimage.median_filter(np.abs(steps), WIDE, mode="mirror")
    finest = resolution(values)
    inner = float(np.ptp(np.cumsum(np.where(np.abs(off) > SCATTER * scatter, speed * dt, steps))))
    wander = float(np.quantile(np.abs(speed), WANDER) * np.quantile(np.abs(dt - usual), WANDER))
    enough = np.maximum(SCATTER * scatter + CHANGES * np.maximum(size, finest), SMALLEST_SHARE * inner) + wander
    jumped = (np.abs(off) > enough) & (dt < GAP_PERIODS * usual)
    places = np.flatnonzero(jumped & _alone(jumped))
    places = places[[not _caught_up(steps, k) for k in places.tolist()]]
    if not places.size or places.size > max(1.0, MOST_SHARE * steps.size):
        return none
    beside = np.clip(places[:, None] + np.array([-2, -1, 1, 2]), 0, steps.size - 1)
    sizes = steps[places] - (steps / dt)[beside] @ np.array([-1.0, 4.0, 4.0, -1.0]) / 6.0 * dt[places]
    further = np.abs(sizes) > OWN_SHARE * np.abs(off[places])
    if not further.any():
        return none
    places, sizes = places[further], sizes[further]
    seam = float(np.median(np.abs(sizes)))
    one = places.size > 1 and float(np.mean(np.abs(np.abs(sizes) - seam) < ALIKE * seam)) > MOSTLY
    for whole in (turn, turn / 2.0):
        if abs(seam - whole) < EXACT * whole and (one or places.size == 1):
            seam, one = whole, True
    if one:
        straight = np.unwrap(values, period=seam)
        count = int(np.count_nonzero(np.abs(np.diff(values - straight)) > 0.5 * seam))
        return Jumps(straight, count, seam, True)
    correction = np.zeros(values.size)
    correction[places + 1] = sizes
    return Jumps(values - np.cumsum(correction), int(places.size), float(np.abs(sizes).max()), False)


def _caught_up(steps: Floats, k: int) -> bool:
    """Whether step `k` makes up for samples before it that repeat the last: as far as the joint moves meanwhile."""
    first = max(0, k - WIDE)
    moving = np.flatnonzero(steps[first:k]) + first
    held = k - 1 - int(moving[-1]) if moving.size else 0
    around = np.concatenate((steps[first:k], steps[k + 1 : k + 1 + WIDE]))
    around = np.abs(around[around != 0.0])
    if not held or around.size < FEWEST_MOVING:
        return False
    return bool(np.abs(steps[k]) <= CATCH_UP * (held + 1) * float(np.median(around)))


def _alone(jumped: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which (n,) jumps have none right beside them: two in a row are an outlier, or a motion."""
    padded = np.concatenate(([False], jumped, [False]))
    alone: NDArray[np.bool_] = ~(padded[:-2] | padded[2:])
    return alone
