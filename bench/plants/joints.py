"""Seven sizes of joint, what each can do, and a draw of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plants.laws import Joint

SPREAD = 0.25
"""Every parameter of a draw lies within this share of the size's own."""


@dataclass(frozen=True)
class Size:
    """A joint, the largest speed it is swept at, rad/s, its largest travel from the middle, rad, and its gear."""

    joint: Joint
    speed: float
    travel: float
    gear: float


SIZES = {
    "prototype": Size(Joint(175.0, 20341.0, 47.4, 236.0, 41.4, 83.0, 8.5, -0.7, -53.4), 0.4, 0.10, 100.0),
    "cobot": Size(Joint(1.5, 12000.0, 2.2, 12.0, 6.0, 3.0, 1.0, 0.0, -8.0), 1.6, 0.10, 100.0),
    "series_elastic": Size(Joint(0.25, 250.0, 0.4, 1.2, 0.8, 0.15, 0.1, 0.1, -1.0), 3.0, 0.25, 50.0),
    "legged": Size(Joint(0.02, 350.0, 0.05, 0.08, 0.25, 0.03, 0.04, 0.02, -0.15), 5.0, 0.25, 9.0),
    "industrial": Size(Joint(40.0, 4.0e5, 200.0, 400.0, 100.0, 60.0, 20.0, 1.0, -30.0), 0.6, 0.06, 150.0),
    "direct_drive": Size(Joint(0.08, 1500.0, 0.12, 0.15, 0.15, 0.10, 0.05, 0.05, -0.3), 5.0, 0.20, 1.0),
    "harmonic_drive": Size(Joint(0.6, 9000.0, 1.2, 8.0, 5.0, 1.0, 0.5, 0.2, -5.0), 1.8, 0.10, 100.0),
}
BASE = ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "MX", "MY")


def drawn_joint(size: Size, rng: np.random.Generator) -> Joint:
    """A joint of this size, every parameter drawn."""
    factors = rng.uniform(1.0 - SPREAD, 1.0 + SPREAD, len(BASE))
    return size.joint._replace(**{k: getattr(size.joint, k) * float(f) for k, f in zip(BASE, factors, strict=True)})
