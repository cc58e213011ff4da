"""The thresholds of the band in one table, each with its source or the bench and seeds that set it."""

from __future__ import annotations

MIN_COHERENCE = 0.6
ENERGY_SHARE = 0.995
ROUNDED_SHARE = 0.9
"""Share of steps that are whole multiples of the smallest one from which a position counts as rounded."""
LINE_COHERENCE, LINE_POWER = 0.7, 30.0
"""Coherence of a line of a multisine, and its power over that of the torque around it."""
RESOLVED = 300.0
"""Power of the motion over that of the rounding: what is rounding, not motion, makes an inertia as much too small, at
the end of the band. At 30 a computed torque under a PRBS at 2 kHz (`bench/coverage.py`, seed 6) moved Jm by 0.2 %."""
