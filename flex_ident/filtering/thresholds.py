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
LINE_WIDTH, LINE_BINS = 0.15, 3
"""Half the width of a line, of its frequency, and in bins of the whole recording at least."""
TONE_SHARE, TONE_SHARE_OF_TORQUE = 0.9, 0.6
"""Share of the energy of velocity and torque about one line from which a motion holds one tone."""
SMOOTHED_S, MOVING_SPEED = 0.05, 0.1
"""Time over which a speed is taken, s; share of the largest from which a joint counts as moving."""
ONE_SPEED, ONE_SPEED_SHARE = 0.1, 0.9
"""Relative difference from the usual speed that counts as that speed, and the share of the moving time that has it."""
