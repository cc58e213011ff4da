"""How much of the weight that a robot's description gives is in the effort: all, or none where it is compensated.

An effort without gravity, fitted as the motor's torque, has first moments that are nearly nothing: gravity is in its
mode alone, to second order in its stiffness over the spring's.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flex_ident.errors import DataError
from flex_ident.estimation.base_fit import base_fit
from flex_ident.estimation.estimate import fit_problem, started_values
from flex_ident.estimation.kind_priors import base_priors
from flex_ident.estimation.thresholds import SHARE_KNOWN
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.notices import Code, Notice
from flex_ident.parameters import FLEXIBLE_KEYS, GRAVITY_KEYS, RIGID_KEYS
from flex_ident.parameters.current import is_current
from flex_ident.parameters.effort_kinds import CURRENT, GRAVITY_COMPENSATED
from flex_ident.recording import Recording, Weight


def gravity_share(recording: Recording, sensors: str, *, rigid: bool = False) -> tuple[float, float] | None:
    """The share of the described weight that the effort holds, with its standard deviation; None without a weight, and
    where no model fits."""
    weight = recording.weight
    if weight is None or weight.moving or not math.hypot(weight.MX, weight.MY) > 0.0:
        return None
    try:
        problem = fit_problem(recording, sensors=sensors, rigid=rigid)
        keys = RIGID_KEYS if rigid else FLEXIBLE_KEYS
        _, fit = base_fit(problem, keys, started_values(problem, keys), base_priors(problem, keys))
    except DataError:
        return None if rigid or sensors == "motor+link" else gravity_share(recording, sensors, rigid=True)
    known = uncertainty_of(fit, problem.rate_hz)
    if not all(known.std(key) < math.inf for key in GRAVITY_KEYS):
        return None
    along = np.array([weight.MX, weight.MY]) / (weight.MX**2 + weight.MY**2)
    both = [fit.free.index(key) for key in GRAVITY_KEYS]
    variance = float(along @ known.covariance[np.ix_(both, both)] @ along)
    return float(along @ fit.values.vector(GRAVITY_KEYS)), math.sqrt(max(variance, 0.0))


def with_gravity_told(recording: Recording, kind: str, sensors: str, *, rigid: bool = False) -> tuple[Recording, str]:
    """The recording with a notice of whether its effort holds the weight that the robot's description gives, and the
    kind of effort that follows from it; as they are without a description, and where the effort is a current of unknown
    scale, of which no share can be told."""
    weight = recording.weight
    if weight is None or kind == CURRENT or is_current(recording.notices):
        return recording, kind
    if any(notice.code is Code.URDF_GRAVITY for notice in recording.notices):
        return recording, kind
    sizes = {"MX": weight.MX, "MY": weight.MY, "share_percent": 0.0, "two_std_percent": 0.0}
    share = gravity_share(recording, sensors, rigid=rigid)
    case = "open"
    if share is not None:
        sizes |= {"share_percent": 100.0 * share[0], "two_std_percent": 200.0 * share[1]}
        case = _case(*share, kind)
    texts = {"case": case, "beside": _reservation(weight)}
    recording = replace(recording, notices=(*recording.notices, Notice(Code.URDF_GRAVITY, "MX, MY", sizes, texts)))
    return recording, GRAVITY_COMPENSATED if case == "absent" and kind == "auto" else kind


def _case(share: float, std: float, kind: str) -> str:
    if not std < 0.5 * SHARE_KNOWN:
        return "open"
    if abs(share - 1.0) < SHARE_KNOWN:
        return "against" if kind == GRAVITY_COMPENSATED else "held"
    if abs(share) < SHARE_KNOWN:
        return "absent" if kind in ("auto", GRAVITY_COMPENSATED) else "against"
    return "other"


def _reservation(weight: Weight) -> str:
    """What was taken for granted of the other joints, as the end of a sentence."""
    if weight.moving:
        return f" ({', '.join(weight.moving)} moved: the weight behind this joint did not stay where it was)"
    return f" (with {', '.join(weight.assumed)} at 0, which nobody recorded)" if weight.assumed else ""
