"""The thresholds of an estimate, in one table, each with its source or the bench and seeds that set it."""

from __future__ import annotations

NO_INERTIA = 0.05
"""Motor inertia over the link's, two standard deviations added, under which there is none: geared motors have 0.2 to
5, and a direct drive without a rotor to speak of has 0.3."""
HARDLY_ANY = 0.01
"""The same under which it is no motor's torque, even if its side explains a little: a cobot's sensor less gravity (an
adversary's) cost 75 in twice the log-likelihood, for 0.06 N m of friction, and was rejected for want of an inertia."""
NO_FRICTION, NO_TORQUE = 0.1, 0.01
"""Of the link's friction, or of the torque, rms: the motor's friction under which there is none."""
AS_LIKELY = 40.0
"""Twice the log-likelihood, in independent samples, that leaving the motor's side out may cost: three keys of a model
with the method's own error at reversals."""
CLEARLY = 20.0
"""Twice the log-likelihood, in independent samples, from which one kind of effort wins over another: 1 in 20,000."""
FAR = 1000.0
"""The same, to first order, from which gravity is in the effort for certain: -1e5 and less for joints that bear any
to speak of; a fit that is far off for want of it showed -42."""
MOST_WITH_LINK = 0.3
"""Share of what the worse model leaves above the noise that the better one must explain. A link encoder shows gravity
to first order, and its own rounding as well; the motor alone to second order, where backlash has passed for it: there
it is asked for."""
SEEN = 4.0
"""Standard deviations from which gravity is seen in the mode."""
STEEL, WIDEST_M = 7850.0, 1.0
"""Density, kg/m^3, and length along the joint's axis, of the body that has the largest first moment for its inertia: a
solid cylinder of steel. Half of its moment is one standard deviation of what a link may have. Without a bound a spring
can pass for an absurd weight: 80 kg m at 2 kg m^2, where a cobot's is 7 and the cylinder's 15."""
HEAVIEST, HEAVIEST_BY_FAR = 3.0, 5.0
"""Usual moments that the effort may be without, and as many where what it explains is beyond doubt: 25 kg m at 2.2
kg m^2 (`cases/gravity_compensated_heavy`) are 3.4, the absurd weight above is 10."""
SHOWN = 0.1
"""First moment in the effort, over a usual one of that inertia, from which it is gravity's own: 0.17 to 0.8 for joints
of `bench/coverage.py` (seed 61), 0.013 and 0.02 where the controller adds gravity (two wide motions of seed 62)."""
LEFT_OVER = 0.25
"""First moment in the effort, over a usual one of that inertia, up to which it may be what a controller leaves of one
that it adds: a tenth of the weight, or a tool of 1.5 kg that nobody entered, put JL 6 to 22 standard deviations off in
six trusted results of an adversary's joints (0.02 to 0.21). Joints of `bench/plants` have 0.3 to 1, but for the
industrial one, 0.12."""
UNSEEN_SHARE = 0.03
"""Share of the link's inertia whose swinging at 1.2 bands, as a tenth at 2.2 bands, nobody would have noticed."""
NOTED_STDS, NOTED_SHARE = 3.0, 0.02
"""Standard deviations, and share, by which an unseen cable must be able to move a first moment to be spoken of."""
MOST_OF_IT, NOTED_OF_ALL = 0.7, 0.005
"""Share of a first moment's standard deviation, and of all gravity, from which what an error of the link encoder would
do is spoken of. Set by hand: an eccentric disk had MX and MY of an adversary's arms 5 to 23 standard deviations off."""
LOSS_MATTERS = 0.1
"""Share of viscous friction by which a loss of the spring that nobody sees must be able to move it to be in its
interval. Set by hand; an adversary's arms, whose springs lost 1 %, had FV 10 to 40 % off. In the intervals whatever its
size, it made FV of clean recordings of the motor alone (`bench/coverage.py`, seed 251) up to 25 times as uncertain."""
STRAIN = 4.0
"""Factor on every standard deviation where a nuisance is at its end: a PRBS commanded and sampled at 500 Hz, whose
torque folds back from above half the rate, moved K by 9 of them."""
STRAIN_MOVES, IDLE_STRAIN = 1.0, 1.5
"""Standard deviations by which a nuisance at its end must move Jm, K or JL to make the result doubtful; the factor on
every one of them otherwise. In five clean recordings of `bench/coverage.py` (seed 11: 2, 16, 21; seed 31: 1 with either
set of sensors) it moved them by 0.4 and less with parameters up to 2.6 off, and by 3 where they were 11 off."""
ROUNDING_DRAWS, ROUNDING_MATTERS = 3, 0.2
"""Draws of an encoder's noise, and how far, in its standard deviations, the first must move a parameter of the joint on
average for that to count."""
LOWER, WORTH_TRYING = 5.0, 20.0
"""Log-likelihood by which a fit from another start must be higher: ten in chi-square, what a finding needs as well; and
by which a few steps from there must lead, under their own weights, to be worth a whole fit. The one recording that
set the second had 4700."""
APART = 3.0
"""Standard deviations of Jm, K or JL by which two ends of a fit that are as likely must differ to be two: in one valley
they differ by 1.4 at most."""
SHARE_KNOWN = 0.35
"""How far from none or all of the described weight the effort's share may lie, and twice how well it must be known: the
masses of a description are often off by a fifth."""
CREEPING = 10.0
"""Speed, over that at which dry friction turns over, up to which the motor is held: set on recording 136 of seed 131
and 35 of seed 161 of `bench/coverage.py`, whose K and FV were further off with 5."""
TURNS_OVER = 1.0
"""Samples that friction's turning over may take for what creeps to be standstill."""
LEAST_MOVING, HARDLY_CREEPS = 0.5, 0.995
"""Share of the usable samples that must be left without what creeps, and from which it is not worth a fit."""
STILL = 0.05
"""Standard deviations by which a round that takes the noise anew may move the parameters for the last: a tenth is
promised for data that are changed in their last digits."""
REVERSAL_ERROR = 0.0005
"""Share of the dry friction that the three laws of its turning over leave open, one standard deviation, as it shows in
FVm and Jm. With 0.003, 0.002 and then 0.0014 errors of FVm were 0.6 to 0.7 of their standard deviations in 204 trusted
results of `bench/coverage.py` (seed 161), 86 (seeds 211 and 231) and 75 (seed 461); of 24 of the last they would be
0.85 with this."""
DRY_REVERSAL_ERROR = 0.0013
"""The same of the dry friction itself: with 0.0025 errors of FSm were 0.6 of their standard deviations in the 86, with
0.0015 they were 0.7 in 42 of seed 481, but 1.26 with 0.0009 in 30 of seed 491."""
CANCELLED = 0.1
"""Of a low-pass's time, within which a delay of the other sign cancels it: a lag of the torque without any lateness is
none. In four of five recordings of `flex_ident demo`, where there is neither, 0.2 to 0.34 ms of each were found, up to
2.8 times the slope's standard deviation."""
LINK_REVERSAL_ERROR, LINK_REVERSAL_SEEN = 0.001, 0.0004
"""The same of the link, and where an encoder on it shows when. What a turning over with speed would do is beside it
(`TURNOVER_SPEEDS`). With 0.0015 and 0.001 errors of FS were 0.7 of their standard deviations in 22 results of the motor
alone and in 20 with both encoders (seed 481), those of FV 0.65 and 0.57; with these they would be 0.76, 0.88, 0.69 and
0.71."""
TURNOVER_SPEEDS = (0.001, 0.003, 0.01, 0.03, 0.1)
"""Speeds at which the link's dry friction may turn over, over the link's rms speed. FV or FS of six trusted results of
seeds 251 and 461 were 3 to 6 standard deviations off without, all of joints whose friction is a tanh of speed: five are
within 2 with it, and the intervals of twelve joints with Coulomb friction stay within 12 % of what they were."""
LINK_CALIBRATION = 1e-5
"""Scale error of a link encoder, one standard deviation, below which no fit knows it: good encoders are accurate to 10
seconds of arc, 5e-5 rad. MY of a leg in wide motion took up 1.5e-5 of it, and was 9 standard deviations off where the
fit claimed to know 1e-6 (`bench/coverage.py`, seed 161, recording 73)."""
AVERAGING_KNOWN = 0.006
"""The same of how the torque is averaged within a sample, in squared samples (a mean or a hold makes 1/24): beside what
the fit itself knows of it. One estimate of -0.037 ± 0.011 had put Jm of an adversary's arm 4.5 standard deviations off,
which set 0.02; that was half of the variance of Jm, K and JL in 42 clean results (`bench/coverage.py`, seed 481), whose
errors were 0.73, 0.63 and 0.65 of their standard deviations, and would be 0.95, 0.70 and 0.75 with this; with 0.01 they
were 0.69, 0.47 and 0.45 in 30 of seed 491. As much of it in all keys, by their covariance with it, made K of a cobot at
500 Hz six times as uncertain as its error is."""
FOLDING = 5.0
"""Set from 18 recordings of three joints commanded at 60 to 200 Hz: K is within two standard deviations with it."""
SENSOR_LEFT = 0.1
"""Share of the torque's energy that the start of a joint sensor's fit may leave where no motor fits."""
DRIFT = 4.0
"""Standard deviations between cutoffs from which an estimate counts as depending on the filter."""
WIDE_HZ, SURE_OF_MODE, BAND_IN_MODES = 60.0, 0.8, 8.0
"""A band wider than so many Hz ends at eight times the free resonance, where that is sure: above it there is only the
motor's inertia, and what a fast controller makes of its encoder's rounding."""
LEAST_PERIODS, LARGEST_BAND = 8.0, 0.4
"""Periods of the highest frequency that a recording must hold; the highest in sampling rates."""
CURVE_NODES, CURVE_SECONDS, CURVE_QUANTILES = 7, 1.0, (0.03, 0.99)
"""Speeds at most of a friction curve in one direction, seconds of motion for each, and the quantiles of speed between
which they lie. Set by hand: what a table still shows."""
CURVE_SPREAD = 0.9
"""Share of its size that friction must have reached for the speed to count."""
CURVE_BEND = 0.25
"""Share of a node's distance from the line between its neighbours that counts as its error, one standard deviation: a
curve of constant bend is fitted a sixth of it off."""
MODE_SEEN, MODE_CLEAR = 0.5, 1.5
"""Confidence with which the resonance is seen, and the end of the band over the locked-motor frequency, under both of
which a sweep has not crossed the mode: chirps cut at 0.9 of it or before have 0.01 to 0.22 and 1.2 to 1.6
(`bench/faulty_recordings.py`), whole recordings 1.75 and more (`bench/coverage.py`, seed 1)."""
CURRENT_ERROR = 5e-4
"""Relative error of each coefficient of the motor's current beyond what its residual tells: Jm was 0.04 to 0.08 % off
in three of six joints of an adversary's plant, where nothing else was to be seen."""
