"""A rigid joint as the base, where the motion shows no spring: as identification takes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flex_ident.estimation.estimate import Estimate
from flex_ident.estimation.rigid import may_be_rigid, rigid_left_percent, rigid_notice, spring_is_open
from flex_ident.gap.options import GapOptions
from flex_ident.judgement.thresholds import GOOD_RIGID
from flex_ident.likelihood.problem import FitProblem
from flex_ident.notices import Code, Notice
from flex_ident.recording import Recording


def _sensors(problem: FitProblem) -> str:
    return "motor" if problem.link is None else "motor+link"


def rigid_alone(recording: Recording, problem: FitProblem, options: GapOptions) -> Notice | None:
    """That a rigid joint is the base, where none with a spring can be fitted."""
    if not may_be_rigid(options, _sensors(problem)):
        return None
    left = rigid_left_percent(recording, prismatic=options.prismatic, band_hz=options.band_hz)
    if left is None or left > GOOD_RIGID:
        return None
    return Notice(Code.TAKEN_AS_RIGID, "K", {"rigid_percent": left}, {"case": "alone"})


def rigid_as_well(recording: Recording, estimate: Estimate, options: GapOptions) -> Notice | None:
    """That a rigid joint is the base, as identification takes it to be where the motion shows no spring."""
    problem = estimate.problem
    if not may_be_rigid(options, _sensors(problem)):
        return None
    left, whole = problem.residuals(estimate.fit.values)[0][problem.usable], problem.torque[problem.usable]
    percent = 100.0 * float(np.linalg.norm(left) / np.linalg.norm(whole))
    notice = rigid_notice(
        recording, percent, open_spring=spring_is_open(estimate), prismatic=options.prismatic,
        band_hz=problem.band_hz, resting_speed=problem.resting_speed,
    )  # fmt: skip
    return None if notice is None else replace(notice, code=Code.TAKEN_AS_RIGID, texts={"case": "as_well"})
