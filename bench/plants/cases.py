"""Recording number i of a seed: which joint, drive, excitation, rate and chain it has, and what is hidden in it.

The choices run through their lists at strides without a common divisor, so that any few dozen in a row are balanced:
every controller meets every joint within 35 recordings and every excitation within 25.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plants.drive import CONTROLLERS
from plants.excitation import EXCITATIONS
from plants.hidden import EFFECTS
from plants.joints import SIZES
from plants.measurement import EFFORTS

RATES = (100.0, 250.0, 500.0, 1000.0, 2000.0)
FRICTIONS = ("coulomb_stepping", "coulomb_events", "tanh")
LAGS_HZ = (30.0, 100.0, 318.0)
FEWEST_SAMPLES = 9.0
"""Samples of a period of the locked-motor frequency below which a recording is of the stratum `slow`."""
DURATION_S, SHORT_S = 40.0, 20.0


@dataclass(frozen=True)
class Case:
    """One recording's place in the design. `stratum`: `standard`, `slow` (few samples a period) or `lag`.

    `effect` and `size` (0 to 2) are of what is hidden, '' and 0 for nothing; `ratio` the drive's ticks a sample.
    """

    seed: int
    index: int
    joint: str
    controller: str
    excitation: str
    rate_hz: float
    ratio: int
    loud: bool
    friction: str
    effort: str
    stratum: str = "standard"
    lag_hz: float = 0.0
    effect: str = ""
    size: int = 0

    @property
    def duration_s(self) -> float:
        """Length of the recording, s."""
        return SHORT_S if self.rate_hz > 1500.0 else DURATION_S

    def generator(self, purpose: int) -> np.random.Generator:
        """Random numbers of this recording for one purpose, the same whatever else is drawn."""
        return np.random.default_rng((self.seed, self.index, int(bool(self.effect)), purpose))


def case_of(seed: int, index: int, hidden: bool = False) -> Case:
    """Recording `index` of `seed`."""
    i = index + 1009 * seed
    joint = list(SIZES)[(i + (i // 21 if hidden else 0)) % 7]
    stratum = "standard" if hidden or i % 12 not in (5, 10) else ("lag" if i % 12 == 5 else "slow")
    locked = SIZES[joint].joint.locked_hz()
    fit = [rate for rate in RATES if rate >= FEWEST_SAMPLES * locked]
    few = [rate for rate in RATES if 4.0 * locked <= rate < FEWEST_SAMPLES * locked]
    if stratum == "slow" and not few:
        stratum = "standard"
    rates = few if stratum == "slow" else fit
    effort = EFFORTS[i % 3]
    friction = FRICTIONS[(i // 3) % 3]
    effect = EFFECTS[i % 21] if hidden else ""
    size = (i // 21) % 3 if hidden else 0
    if effect == "saturation":
        effort = "command"
    if effect == "mujoco_frictionloss":
        friction = "mujoco"
    elif effect in ("hysteresis", "second_mode", "mount", "lugre"):
        friction = "coulomb_stepping"
    return Case(
        seed, index, joint, CONTROLLERS[(i + (i // 21 if hidden else 0)) % 5],
        EXCITATIONS[(2 * i + i // 5) % 5], rates[(i // 7 + i) % len(rates)], 1 + (i // 2) % 4, (i // 4) % 2 == 0,
        friction, effort, stratum, LAGS_HZ[(i // 12) % 3] if stratum == "lag" else 0.0, effect, size,
    )  # fmt: skip
