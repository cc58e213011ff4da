"""What an effort cut toward zero would do to the parameters, where nothing tells it from a rounded one."""

from __future__ import annotations

import numpy as np

from flex_ident.estimation.unseen_effects import opened_by
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Code, Notice
from flex_ident.recording import Floats, Recording

UNKNOWN = 0.7
"""Standard deviation, in halves of a step, of what was cut off: 0 where it was rounded, 1 where it was cut, each as
likely."""
PART = 0.1
"""Share of a variance from which its cause is spoken of: it makes the interval 5 % wider."""


def untold_step(recording: Recording) -> float:
    """The step of an effort of which it is not known whether it was rounded or cut; 0 where it is, or has none."""
    return next((s.untold_step for s in recording.sampling if s.role == "motor_torque"), 0.0)


def cut_covariance(solver: SteadyFit, fit: Fit) -> Floats:
    """What that leaves open of the free keys, (p, p); nothing where it is known."""
    problem = solver.problem
    step = untold_step(problem.recording)
    if step == 0.0:
        return np.zeros((len(fit.free), len(fit.free)))
    cut = problem.reduced(0.5 * UNKNOWN * step * np.sign(problem.recording.motor_torque))
    changes = (cut, *(np.zeros_like(cut) for _ in fit.whitenings[1:]))
    return opened_by(fit, solver.whitened(changes, fit.whitenings)[:, None])


def cut_notice(recording: Recording, cut: Floats, whole: Floats) -> Notice | None:
    """That the intervals hold it; None where it is no part of any that a person should know of. Both are (p, p)."""
    if not np.any(np.diag(cut) > PART * np.diag(whole)):
        return None
    [source] = [s.source for s in recording.sampling if s.role == "motor_torque"]
    return Notice(Code.EFFORT_STEPS, source, {"step": untold_step(recording)})
