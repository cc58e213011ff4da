"""The thresholds of the linear methods in one table, each with its source or the bench and seeds that set it."""

from __future__ import annotations

BIC_GAIN = 10.0
CANCELLED = 0.1
"""Share of gravity's mean torque that a constant leaves of it, from below which the two only hold each other up."""
CERTAIN = 3.0
STRONG_SHARE = 0.2
"""Share of a small singular vector from which a column is named as part of the undetermined combination."""
DETERMINED = 0.2
