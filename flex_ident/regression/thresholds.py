"""The thresholds of the linear methods in one table, each with its source or the bench and seeds that set it."""

from __future__ import annotations

BIC_GAIN = 10.0
CANCELLED = 0.1
"""Share of gravity's mean torque that a constant leaves of it, from below which the two only hold each other up."""
CERTAIN = 3.0
STRONG_SHARE = 0.2
"""Share of a small singular vector from which a column is named as part of the undetermined combination."""
DETERMINED = 0.2
HIGHEST_BAND_HZ = 15.0
"""Of the motor's equation. The deflection follows the torque; far above, the link encoder's skew and noise dominate it.
Of an adversary's arms, looked at, K was up to 2.9 standard deviations off with 10 Hz, 2.5 with 15, and that of a light
wrist 4.8 with 25."""
CORRELATION_S = 0.2
"""Lag up to which the residual of the motor's equation counts as correlated, s. Set by hand."""
OWN_ERROR = 0.002
"""Share of K that the motor's equation leaves open by itself, one standard deviation: a low-pass in the effort is more
than late, dry friction turns over between samples. Of an adversary's 78 arms, looked at, half are within 0.05 %, and a
low-pass of 150 Hz makes 0.35."""
