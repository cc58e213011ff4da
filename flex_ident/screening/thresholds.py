"""The thresholds of what may be missing in one table, each with its source or the bench and seeds that set it."""

from __future__ import annotations

BY_CHANCE = 1e-4
"""Probability, of Fisher's test, under which what is in common is no chance."""
LEAST_SHARE = 0.05
"""Share of what is left, by energy, that the other joints' motion must explain where it was not fitted."""
VISIBLE = 10.0
"""Size of an effect's mark on the whitened residual, beyond what the model itself can do, from which it is testable."""
IMITATED = 1e-3
"""Share of a signature beyond the model's own parameters under which what is left of it is rounding, and no size."""
STRONG = 40.0
"""Gain beyond its price from which an effect is worth a rough refit, and speaks against the model."""
SHOWS = 10.0
"""Standard deviations from which a nuisance that stands for an effect out of sight shows, and may stand for another: a
base that gives way made one of 1250 (`bench/coverage.py --hidden`, seed 73, recording 7)."""
LEAST_WEIGHT = 0.02
NO_CAUSE = 2.0
"""Factor on what structure does to the intervals where no suspect accounts for half of it: a base that gives way, the
law of friction in MuJoCo and a drive's own dynamics moved Jm, K and JL by up to that much more."""
ENOUGH = 0.9
"""Share of what is left above the noise, by energy, from which a suspect that accounts for it is not doubted by another
mode: as explain's, which `gap.thresholds` has of the closable gap."""
