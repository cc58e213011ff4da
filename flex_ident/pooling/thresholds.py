"""The thresholds of this stage in one table, each with its source."""

from __future__ import annotations

LEAST_STATISTICAL = 0.1
"""Share of a recording's variance that is its own at least: recordings never share all of it. Set by hand."""
SCATTERS = 0.05
"""Chance of as much scatter by a recording's own uncertainty alone, under which recordings are said to scatter."""
TWO_SCATTER = 0.2
"""The same for two recordings, under which their interval takes the quantile of one degree of freedom (12.7). Above, it
reaches over both intervals: `test/pooling/test_combining.py` has what that covers."""
DISAGREES = 0.05
"""Chance, over all recordings and parameters together, under which a recording is said to disagree."""
FEWEST_TO_DISAGREE = 4
"""Recordings from which one can be told from the others."""
NAMED = 0.05
"""Chance, over all conditions and parameters together, under which a condition is named as the cause of scatter."""
FEWEST_FOR_CONDITION = 5
"""Recordings from which a condition is looked for: four have 24 orders, too few for a chance under 5 %."""
PERMUTATIONS = 2000
"""Random orders of the recordings; all of them where there are fewer."""
ALIKE = 0.9
"""Correlation of two conditions from which the recordings cannot tell them apart. Set by hand."""
LARGEST_SCALE_ERROR = 0.1
"""Relative standard deviation of the effort's scale from which a known mass does not tell it. Set by hand."""
DIFFERENT_SCALES = 0.01
"""Chance under which the scales by inertia and by gravity are said to differ."""
SCALE_OFF_STDS = 3.0
"""Standard deviations from 1 from which the effort is said to have another scale than it was taken with."""
LARGEST_ERROR = 0.3
"""Relative standard deviation of a parameter, scatter included, from which it is not identifiable: that of a single
recording (`judgement.thresholds.RELATIVE_LIMIT`)."""
FEW_TOGETHER = 2.0
"""By how much few recordings may widen a standard deviation that hardly matters in each of them. Set by hand."""
LEAST_SPREAD = 0.05
"""Share of its size by which a condition that is computed from the recordings must differ between them. Set by hand."""
DIFFER = 0.01
"""Chance under which two results of one joint are said to differ. Set by hand."""
LEAST_DIRECTION = 1e-6
"""Variance of a combination over the largest, of correlations, under which it is left out: a thousandth in size."""
FALSE_CHANGES = 0.01
"""Share of the changes named over a fleet that may be false on average: the chance of any where nothing changed."""
FEWEST_TO_SHARE_SCATTER = 5
"""Series from which what they have in common of their scatter is estimated: it is a variance of variances. By hand."""
FEWEST_PAIRS = 20
"""Series of two results each from which their scatter is estimated, by the median. Set by hand."""
FIRST_SESSIONS = 3
"""Sessions of a joint that are its baseline where none is named; less where two would not be left. Set by hand."""
SESSION_S = 12 * 3600.0
"""Time from a session's first recording within which others are of the same session, s: a working day. Set by hand."""
FEWEST_DEGREES = 2.0
"""Degrees of freedom under which a scatter counts as unknown: with one, Student's quantile is 12.7. By hand."""
HETEROGENEITY_CAUTION = 0.5
"""Fall of the log-likelihood up to which series are taken to differ more in their scatter than they seem to: one
standard error."""
FEW_DAYS = 6
"""Sessions up to which a step that most joints share is put down to the days. In `bench/health_sessions.py` what a
robot's joints share gave false alarms in 15 % of fleets of four days without it."""
