"""A rigid joint as the base, where the motion shows no spring: as identification takes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flex_ident.estimation.effort_kind import KindFit
from flex_ident.estimation.rigid import rigid_left_percent, rigid_notice
from flex_ident.gap.options import GapOptions
from flex_ident.judgement.thresholds import GOOD_RIGID, RELATIVE_LIMIT
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.problem import FitProblem
from flex_ident.notices import Code, Notice
from flex_ident.recording import Recording


def _may_be_rigid(problem: FitProblem, options: GapOptions) -> bool:
    given = options.model is not None or options.first_mode_hz is not None
    return not options.rigid and problem.link is None and not given


def rigid_alone(recording: Recording, problem: FitProblem, options: GapOptions) -> Notice | None:
    """That a rigid joint is the base, where none with a spring can be fitted."""
    if not _may_be_rigid(problem, options):
        return None
    left = rigid_left_percent(recording, prismatic=options.prismatic, band_hz=options.band_hz)
    if left is None or left > GOOD_RIGID:
        return None
    return Notice(Code.TAKEN_AS_RIGID, "K", {"rigid_percent": left}, {"case": "alone"})


def rigid_as_well(recording: Recording, problem: FitProblem, kinds: KindFit, options: GapOptions) -> Notice | None:
    """That a rigid joint is the base, as identification takes it to be where the motion shows no spring."""
    if not _may_be_rigid(problem, options):
        return None
    fit = kinds.fit
    left, whole = problem.residuals(fit.values)[0][problem.usable], problem.torque[problem.usable]
    percent = 100.0 * float(np.linalg.norm(left) / np.linalg.norm(whole))
    std = uncertainty_of(fit, problem.rate_hz).std("K")
    notice = rigid_notice(
        recording, percent, open_spring=not std <= RELATIVE_LIMIT * fit.values["K"], prismatic=options.prismatic,
        band_hz=problem.band_hz,
    )  # fmt: skip
    return None if notice is None else replace(notice, code=Code.TAKEN_AS_RIGID, texts={"case": "as_well"})
