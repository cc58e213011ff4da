"""The thresholds of all verdicts in one table, each with the bench and seeds that set it, or set by hand."""

from __future__ import annotations

RELATIVE_LIMIT = 0.3
"""A parameter less certain than this, relative to itself, is identifiable only if small in effect. Set by hand."""
EFFECT_LIMIT = 0.01
"""Share of the torque's rms that an uncertainty may move for a parameter near zero to count as known. Set by hand."""
WEAK_PERCENT = 5.0
"""Relative standard deviation of an essential parameter from which a result is doubtful. Set by hand."""
POOR_PERCENT, HOPELESS_PERCENT = 15.0, 50.0
"""Torque left unexplained, in percent, from which a result is doubtful, and rejected. Set by hand: what is left beyond
the noise is judged before it comes to this. A fit that leaves known noise and nothing else is not doubtful for it: a
clean joint of an adversary, whose effort was noise to 19 %, was sent to look for what is missing."""
UNSEEN_RATIO, UNSEEN_PERCENT = 1.5, 2.0
"""The error on seconds left out of the fit over that on the others, and what is added, from which it is doubtful. Set
by hand."""
SAMPLES_A_PERIOD = 10.0
"""Samples in a period of the locked-motor frequency under which a result is doubtful: set with what folds back onto it,
on 18 recordings of three joints commanded at 60 to 200 Hz."""
CERTAIN_GAIN = 300.0
"""Gain of an effect that leaves no gap from which it counts: jitter of the clock made up to 210 in the link channel of
the virtual paper joint, and 130 in `bench/coverage.py`, seed 1."""
SCALE_GAIN = 60.0
"""The same of an effect that scales the torque: a loss over speed, commanded torque recorded, showed 150 and 240 where
it moved K by 30 standard deviations; 28 results of clean recordings under 0 (`bench/coverage.py`, seed 61)."""
MOVED = 5.0
"""Standard deviations by which an effect that the recording shows must move a parameter to make the result doubtful:
set on `bench/coverage.py`, seed 1."""
LATE_STDS = 2.0
"""Standard deviations beyond a sample from which a signal counts as recorded late."""
DRIFT_STDS, DRIFTED = 4.0, 0.2
"""Standard deviations, and sampling periods over the recording, from which a clock's drift is worth a word."""
X5_DOUBTFUL, X5_REJECTED = 2.0, 10.0
"""Standard deviations between the measured X5 and the one that follows from the other combinations (Table 3)."""
GOOD_RIGID = 15.0
"""Percent of the torque that a rigid joint may leave and still be worth trying where no spring was found."""
RIGID_MARGIN = 1.1
"""What a rigid joint leaves over what the spring leaves up to which the spring has not earned its place."""
SURELY_RIGID = 1.5
"""What a first rigid fit leaves over what counts from which a careful one, which saves a tenth or two, is not made."""
MOST_RIGID = 50.0
"""Percent from which a rigid joint explains nothing either."""
