"""What is estimated beside the joint: the measurement chain, the link's start, how friction turns over at reversals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flex_ident.effects import effect_named
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.thresholds import (
    AT_ITS_END,
    FAR_SHARE,
    LARGEST_FAR_SHARE,
    LEAST_FAR_SHARE,
    PHYSICAL_AVERAGING,
    PHYSICAL_LEAD_S,
)
from flex_ident.parameters.keys import key_text
from flex_ident.parameters.parameter import FAR_MODE
from flex_ident.parameters.prior import Prior
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording

LATE_SAMPLES = 3.0
"""Samples by which a signal may be recorded late or early and be corrected for."""
LARGEST_LAG_S = 0.02
USUAL_LAG_S = 2e-3
"""Low-pass in the recorded effort: drivers filter at 10 Hz (16 ms) and more."""
USUAL_LEAD_S, LARGEST_LEAD_S = 3e-3, 0.03
"""Time by which friction may turn over before or after the velocity does; MuJoCo's friction loss leads by 10 ms."""
USUAL_SCALE, LARGEST_SCALE = 1e-3, 3e-3
"""Scale error of a link encoder: a disk eccentric by a thousandth of its radius reads up to that much too far.
With 1 % and more it would pass for gravity that is not in the effort."""
USUAL_DRIFT, LARGEST_DRIFT = 2e-5, 5e-4
"""Difference of rate between two clocks: quartz is right to 20 parts in a million each, as its makers say; what is far
more shows in the times of reception."""
TURNOVER = 0.1
"""Speed, relative to the rms speed, and way, relative to the range, over which friction may turn over, one std."""


def measurement_priors(problem: FitProblem, *, late_samples: float = LATE_SAMPLES) -> dict[str, Prior]:
    """Priors of the nuisances that matter for this problem.

    Torque may be logged early or late by up to `late_samples` periods, behind a low-pass (no longer than that either,
    where they are fewer than usual), as a mean over a period or as a held command (kappa = ±1/24); the link encoder may
    be skewed likewise and has a zero and a scale of its own. The motor's dry friction may turn over with speed, with
    the way moved, or early. A part of the link may swing above the band, which a link encoder tells from a softer or a
    stiffer spring; for a motor alone see `estimation.far_mode`.
    """
    ts = problem.recording.sample_time
    limit = late_samples * ts
    slowest = LARGEST_LAG_S if late_samples >= LATE_SAMPLES else min(limit, LARGEST_LAG_S)
    speed = float(np.std(problem.motion.velocity)) + 1e-12
    reach = float(np.ptp(problem.motion.position))
    priors = {
        "torque_delay": Prior(0.0, ts, -limit, limit),
        "torque_averaging": Prior(0.0, 1.0 / 24.0, -0.125, 0.125),
        "effort_lag": Prior(0.0, USUAL_LAG_S, 0.0, slowest),
        "reversal_speed": Prior(0.0, TURNOVER * speed, 0.0, 3.0 * speed, start=1e-3 * speed),
        "presliding": Prior(0.0, TURNOVER * reach, 0.0, reach, start=1e-4 * reach),
        "reversal_lead": Prior(0.0, USUAL_LEAD_S, -LARGEST_LEAD_S, LARGEST_LEAD_S),
    }
    if not problem.rigid:
        # The link starts somewhere in the band of its static friction; the trimmed start forgets most of it.
        spread, widest = 0.05 * reach + 1e-9, 20.0
        if problem.link is not None:
            moved = problem.motion.position[:: problem.decimation] - problem.link
            spread, widest = float(np.std(moved[problem.usable])) + 1e-9, 4.0
        priors["initial_deflection"] = Prior(0.0, spread, -widest * spread, widest * spread)
        start = speed + 1e-9
        priors["initial_velocity"] = Prior(0.0, start, -10.0 * start, 10.0 * start)
    if problem.link is not None:
        far = 10.0 * reach + 10.0
        apart = float(np.median(problem.link - problem.motion.position[:: problem.decimation]))
        priors["link_skew"] = Prior(0.0, ts, -limit, limit)
        # Counters that were never set to the same zero may be any number of turns apart.
        priors["link_zero"] = Prior(apart, far, apart - 10.0 * far, apart + 10.0 * far, start=apart)
        priors["link_scale"] = Prior(0.0, USUAL_SCALE, -LARGEST_SCALE, LARGEST_SCALE)
        priors[FAR_MODE] = far_mode_prior()
        if has_own_clock(problem.recording):
            priors["link_drift"] = Prior(0.0, USUAL_DRIFT, -LARGEST_DRIFT, LARGEST_DRIFT)
    return priors


def has_own_clock(recording: Recording) -> bool:
    """Whether the link's position may be stamped by another clock than the motor's: it comes in other messages."""
    topics = {s.role: s.source.partition(":")[0] for s in recording.sampling}
    return topics.get("link_position") != topics.get("motor_position")


def far_mode_prior() -> Prior:
    """What is known of the share of the link's inertia that swings above the band."""
    return Prior(0.0, FAR_SHARE, LEAST_FAR_SHARE, LARGEST_FAR_SHARE)


CHAIN = (
    "torque_delay",
    "torque_averaging",
    "effort_lag",
    "reversal_lead",
    "link_skew",
    "link_scale",
    "link_drift",
    "far_mode",
)
"""Nuisances that have an end beyond which there is something else."""
PHYSICAL_ENDS = {"torque_averaging": PHYSICAL_AVERAGING, "reversal_lead": PHYSICAL_LEAD_S}
"""Ends that are known, of the chain or of drives, within what a fit may try."""


def strained(values: Values, priors: Mapping[str, Prior]) -> tuple[str, ...]:
    """The nuisances of the measurement chain that stand in for something else: at the end of what they can be.

    A mean over a period of the torque, or a hold, makes 1/24 of a period squared; no friction of a drive leads by over
    5 ms.
    """
    found = []
    for key in CHAIN:
        if key not in priors or key not in values:
            continue
        value, prior = values[key], priors[key]
        end = prior.upper if value > 0.0 or prior.lower == 0.0 else -prior.lower
        end = PHYSICAL_ENDS.get(key, AT_ITS_END * end)
        if abs(value) >= end:
            found.append(key)
    return tuple(found)


def model_priors(
    problem: FitProblem, effects: Sequence[str] = (), *, late_samples: float = LATE_SAMPLES
) -> dict[str, Prior]:
    """The same for a model that has `effects`: each brings its own priors, and replaces its nuisance."""
    priors = measurement_priors(problem, late_samples=late_samples)
    for name in effects:
        effect = effect_named(name)
        for key in (effect.replaces, *effect.stand_ins):
            priors.pop(key, None)
        if effect.priors is not None:
            own = effect.priors(np.abs(problem.recording.motor_torque))
            priors.update({key_text(name, key): prior for key, prior in own.items()})
    return priors
