"""Each estimate against the filter's cutoff: a good estimate does not depend on it (the paper's ref. 11)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flex_ident.errors import DataError
from flex_ident.estimation.estimate import Estimate
from flex_ident.estimation.thresholds import DRIFT
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import SimulationFit
from flex_ident.likelihood.nuisances import measurement_priors
from flex_ident.likelihood.problem import FitProblem
from flex_ident.notices import Code, Notice
from flex_ident.parameters import CutoffSweep, Parameter
from flex_ident.recording import Recording

FACTORS = (0.5, 0.7, 0.85, 1.2)
"""Cutoffs tried beside the one that was used, relative to it."""
SHOWN = ("Jm", "K", "JL", "FVm", "FV", "FSm")
ITERATIONS = 4


def swept_cutoffs(
    recording: Recording, estimate: Estimate, parameters: tuple[Parameter, ...], *,
    progress: Callable[[float], None] | None = None,
) -> CutoffSweep:  # fmt: skip
    """The fit repeated at other cutoffs, from its optimum. Cutoffs at which too little is left are skipped."""
    used = estimate.problem
    keys = [p.key for p in parameters if p.key in SHOWN and p.identifiable]
    rows = [(used.cutoff_hz, {k: (estimate.fit.values[k], estimate.uncertainty.std(k)) for k in keys})]
    for i, factor in enumerate(FACTORS):
        if factor > 1.0 and factor * used.cutoff_hz > 0.45 * recording.sample_rate_hz:
            continue
        try:
            problem = FitProblem(recording, sensors=used.sensors, band_hz=factor * used.band_hz)
            solver = SimulationFit(problem, priors=measurement_priors(problem))
            values = estimate.fit.values
            fit = solver.solve(
                estimate.fit.free, values, solver.whitenings(values), iterations=ITERATIONS, tolerance=1e-4
            )
        except DataError:
            continue
        spread = uncertainty_of(fit, problem.rate_hz)
        rows.append((problem.cutoff_hz, {k: (fit.values[k], spread.std(k)) for k in keys}))
        if progress is not None:
            progress((i + 1) / len(FACTORS))
    rows.sort(key=lambda row: row[0])
    return CutoffSweep(
        np.array([2.0 * np.pi * cutoff for cutoff, _ in rows]),
        {k: np.array([found[k][0] for _, found in rows]) for k in keys},
        {k: np.array([found[k][1] for _, found in rows]) for k in keys},
    )


def cutoff_notices(sweep: CutoffSweep, parameters: tuple[Parameter, ...], used_rad_s: float) -> list[Notice]:
    """A notice for each essential parameter that a cutoff near the one used would move beyond its uncertainty."""
    notices = []
    for p in parameters:
        if p.key not in ("Jm", "K", "JL") or p.key not in sweep.values:
            continue
        for cutoff, value, std in zip(sweep.cutoff_rad_s, sweep.values[p.key], sweep.stds[p.key], strict=True):
            near = 0.6 * used_rad_s < cutoff < 1.3 * used_rad_s
            if near and abs(value - p.value) > DRIFT * max(float(np.hypot(std, p.std)), 2e-3 * abs(p.value)):
                found = {"there": value, "cutoff_rad_s": cutoff, "here": p.value, "used_rad_s": used_rad_s}
                notices.append(Notice(Code.CUTOFF_DEPENDENT, p.key, found))
                break
    return notices
