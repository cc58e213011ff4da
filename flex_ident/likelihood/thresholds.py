"""The thresholds of what is left, in one table, each with its source or the bench and seeds that set it."""

from __future__ import annotations

OWN_ERROR = 0.003
"""Share of the torque's rms under which what is left is the method's own error (integration, filters), not physics."""
OWN_ERROR_AT_REVERSALS = 0.05
"""Share of the Coulomb friction that a clean joint leaves at its reversals: the method's own error there."""
OWN_ERROR_RINGING = 0.15
"""Share of the link's Coulomb friction that its reversals leave in a torque measured behind the gear: they ring at the
locked-motor frequency, and no friction of a motor is there to hide it. Of a plant whose friction is tanh(v / 1e-3)."""
OWN_ERROR_OF_LINK = 0.008
"""Share of the spring's deflection, rms, that may be left of the link's position: 20 clean recordings of
`bench/coverage.py`, seed 6, leave up to 0.006 (a motor that sticks); a link encoder behind a further spring 0.01 to
0.05, with K 20 to 150 standard deviations off."""
STRUCTURE = 1.2
"""Gap over the noise floor from which what is left counts as structure."""
LEAST_KNOWN = 0.2
"""Share of the samples that must be left when those at which the motor sticks are not counted."""
QUANTILE = 0.3
"""Model error comes and goes with the motion, noise stays: the lower part of the segments shows the noise."""
ABOVE = (1.3, 3.0)
"""Where the noise above the motion is taken, in cutoffs of the comparison's low-pass."""
WIDE_ENOUGH = 1.2
"""Upper over lower end of that range from which it holds enough to judge by."""
QUIET_RATIO = 1.5
"""Steady part of the torque over that of what the model leaves up to which both are taken from cells without motion."""
HIGHEST = (0.3, 0.48)
"""Where the noise of a position is taken, in sampling rates: far above what a joint follows."""
LOUDER = 1.25
"""Power of what is left over that of the noise from which a stretch counts as worse than noise: chance alone makes 1.2
of the mean of two seconds of whitened samples at 100 Hz."""
FAR_BANDS, FAR_DAMPING = 1.2, 0.02
"""Where a mode above the band is put, in bands, and its damping ratio. Within the band it is little but its inertia
over the square of its frequency, so that a mode at 2.4 bands is held as well as one at 1.3 (test_far_mode.py); put at
1.5 it left K 5 standard deviations off under a mode at 1.3."""
FAR_SHARE, LEAST_FAR_SHARE, LARGEST_FAR_SHARE = 0.1, -0.2, 0.5
"""Share of the link's inertia behind it: one standard deviation, the least that chance may make, and the most. A link's
first bending mode has a tenth or so; without it K of 16 recordings of an adversary's joints, modes at 2.5 to 4 times
the free resonance, was 12 to 57 standard deviations off, and trusted."""
AT_ITS_END, PHYSICAL_AVERAGING = 0.99, 2.0 / 24.0
"""Share of its range from which a nuisance is at its end; twice what a mean or a hold over a period can make."""
PHYSICAL_LEAD_S = 0.005
"""Time by which the friction of a motor may turn over before its velocity does: no drive's does by more than 5 ms among
98 clean recordings of `bench/coverage.py`, seed 71, but for motors that rest between the steps of a PRBS under P-PI
control. Those showed 7 to 20 ms, and K 3 to 6 standard deviations off (also seeds 31 and 61). MuJoCo's friction loss,
which leads by 10 ms, is an effect of its own."""
UNSEEN_WAY = 0.1
"""Way over which friction turns over, in standard deviations of the encoder's noise, of which nothing can be told.
Without it fits crept for most of their time through ways of a hundredth of that, where the cost has a minimum of its
own (`bench/coverage.py`, seed 1, recordings 7 and 14)."""
WEAK_SINGULAR_VALUE = 1e-6
"""Relative to the largest: what differences cannot tell from zero. A link encoder may be 1e5 times as precise as a
torque, and yet the torque alone tells the scale of all forces."""
FEWEST = 60
"""Usable samples of the decimated clock without which nothing is fitted."""
HARDLY = 0.5
"""Share of the time in motion under which standstill is why too little is left."""
MOST_SETTLING = 0.4
"""Share of a recording that may be lost to that."""
POOR = 0.25
"""Share of the torque's energy that a start may leave before the opposite sign is tried."""
ALIKE = 0.995
"""Correlation of the motor position with itself one period later from which motion counts as repeated."""
