"""The thresholds of the search in one table, each with its source or the bench and seeds that set it."""

from __future__ import annotations

CERTAIN = 3.0
"""Standard deviations from which a constant torque is there, and is an effect to be found."""
VISIBLE = 1.03
"""Gap over the noise floor from which it makes sense to say where it lies."""
NOT_A_MODEL = 0.95
"""Gap of the base over the torque's standard deviation from which the recording is not of such a joint."""
AT_THE_LIMIT = 0.99
"""Of a sample: a delay or skew that the fit would have larger."""
PERIODS = 2.0
"""Periods within the range of motion from which an effect can be called periodic."""
WORTH_A_TRIAL = 12.0
"""Twice the log-likelihood that screening must promise."""
MIMICKED = 0.03
"""Share of an effect's signature beyond the model's own parameters under which its linear estimate says nothing."""
QUIET = 0.3
"""Excess over the noise under which a second mode is not searched for deeply."""
ENOUGH = 0.9
"""Share of the closable gap from which what closed it is not doubted by a second mode."""
CLOSES_ALL = 0.8
"""Share of the closable gap that a cause must close where what is left is within the method's own error. Five of six
false names of seeds 401 and 431 of `bench/coverage.py` were given there, and closed 53 to 77 %; a friction of 1.9 % of
the load (`bench/confusion.py`, seed 421) closed 94 %."""
MOST_OF_IT = 0.67
"""Share of the closable gap that all accepted effects must close together to be called its causes."""
NEAR_TIE = 6.0
"""Difference of the BIC under which two effects cannot be told apart."""
OFF_SIGMAS = 3.0
EVIDENCE = 10.0
"""Fall of the Bayesian information criterion from which a candidate counts (Kass and Raftery: very strong)."""
HELD_OUT_T = ((0.8, 1.1), (0.5, 1.8), (0.0, 2.5))
"""By the share of the closable cost on left-out data that is saved, the t over blocks that is needed: what saves most
of it may lie all in a resonance or where the torque saturates, but not in one block."""
LEAST_PERIODS = 0.9
"""Of what is periodic in the motor's angle, within the range of motion: a part of a period is gravity or a spring."""
OVER_FILTER = 5.0
"""Of what the low-pass changes of the position at reversals, rms, that a way must exceed: its largest is three times
that. Seed 401 of `bench/coverage.py`, recording 6, where dry friction stops the motor and holds it: 4.6."""
SMALLEST_SHARE = 0.2
"""Share of the closable gap that a cause must close to be called one; a false name closes a few percent."""
SIGNIFICANT_STATED = 1.96
"""Stated standard deviations, with all that could be missing, that an accepted effect must differ from nothing by: its
95 % interval must not hold nothing. A Stribeck peak of 5.9 ± 11 N m was accepted on a joint that had none
(`cases/fast_loop`), and one of 36 ± 56 in seed 231 of `bench/coverage.py`, recording 11."""
SIGNIFICANT = 3.0
SIGNIFICANT_SHAPE = 2.0
"""Standard deviations to which its shape must be known: hysteresis over no deflection at all is dry friction."""
OWN_ERROR = 2e-3
"""Change of the torque, relative, that the method's own error may make; of the deflection it is what `likelihood` takes
for it. Two clean joints with fine link encoders had a name for 0.14 % of the torque (`bench/coverage.py --explain`,
seed 181); a hidden delay of 5 ms changes 0.3 % (`bench/confusion.py`, seed 321)."""
WORTH_ANOTHER = 0.8
"""Share of the cost that such a round must leave at most for another to follow."""
CARRIED_T = 2.5
"""The t over blocks from which a recording confirms, or below whose negative it contradicts, an effect as others have
it: that of `HELD_OUT_T` for what saves little."""
MOST_CURVES = 2
"""Laws that are measured as curves, at most: of what is left after two a third would tell little."""
CURVE_COUNTS = (4, 8, 12)
"""Points of a curve, at most, in each direction of motion, or twice as many over a range; each number is tried."""
CURVE_EDGE = 0.001
"""Share of the samples beyond the last point of a curve."""
CURVE_SECONDS = 0.1
"""Time that the recording must spend around each point."""
CURVE_BEND = 0.1
"""Share of a point's distance from the line between its neighbours that counts as the curve's error there, one standard
deviation: a cubic follows what bends evenly, not what bends once more between two points. Set on seed 1 of
`bench/unnamed_laws.py`, where 0.05 covered 81 % of one of three laws."""
IN_BAND = 0.95
"""Share of a curve's length at which a named law must lie within the band to be what it looks like."""
ALIKE = 0.01
"""Share of the largest torque of a curve by which a law may miss it where the band is narrower than that."""
NOTHING = 0.02
"""Share of the largest torque of a curve under which a part of a law is not worth a word."""
CURVE_SHARE = 0.5
"""Share of the closable gap that a curve must close: a law that is free over its variable leaves little of what depends
on it. One of 22 clean recordings of `bench/unnamed_laws.py --clean`, seed 92, had a curve that closed a quarter."""
