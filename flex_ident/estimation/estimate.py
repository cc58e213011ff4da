"""From a recording to the maximum-likelihood fit: start, whitening, refinement; and what it did not see."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.estimation.covariance import Uncertainty, uncertainty_of
from flex_ident.estimation.fit import Fit, Prior, SimulationFit
from flex_ident.estimation.nuisances import measurement_priors
from flex_ident.estimation.problem import Bools, FitProblem
from flex_ident.estimation.start import scanned_start
from flex_ident.filtering.band import excited_band_hz
from flex_ident.parameters import FLEXIBLE_KEYS, RIGID_KEYS
from flex_ident.recording import Recording
from flex_ident.regression.verdict import REVERSED

Progress = Callable[[float], None]
VALIDATION_BLOCK_S = 1.0
VALIDATION_EVERY = 4


@dataclass(frozen=True)
class Estimate:
    """A fit with its uncertainty, and the same keys fitted without the validation part."""

    problem: FitProblem
    fit: Fit
    uncertainty: Uncertainty
    validation: Bools
    """Where (m,) the fit `trained` did not look."""
    trained: Mapping[str, float]


def validation_blocks(problem: FitProblem) -> Bools:
    """Every fourth second of the decimated clock (m,): the part that a validation keeps from the fit."""
    block = np.floor(problem.time / VALIDATION_BLOCK_S).astype(int)
    held: Bools = (block % VALIDATION_EVERY) == VALIDATION_EVERY - 1
    return held & problem.usable


def rigid_start(problem: FitProblem, keys: Sequence[str]) -> dict[str, float]:
    """Linear least squares of a rigid joint's base keys: the start of its fit."""
    terms = {key: problem.prediction({key: 1.0}).torque[problem.usable] for key in keys}
    columns = np.column_stack(list(terms.values()))
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    solution, *_ = np.linalg.lstsq(columns / scale, problem.torque[problem.usable], rcond=1e-8)
    values = dict(zip(keys, map(float, solution / scale), strict=True))
    if values.get("J", 1.0) <= 0.0:
        raise ExcitationError(f"the inertia comes out negative: {REVERSED}")
    return {k: max(v, 0.0) if k in ("FV", "FS") else v for k, v in values.items()}


def fit_problem(
    recording: Recording,
    *,
    sensors: str,
    rigid: bool = False,
    first_mode_hz: float | None = None,
    stiffest: float | None = None,
) -> FitProblem:
    """The problem over the band that the recording excites; `stiffest` is the fastest mode to integrate, in bands.

    Raises ExcitationError.
    """
    band = excited_band_hz(recording)
    if first_mode_hz is not None and first_mode_hz > 1.5 * band and not rigid:
        raise ExcitationError(
            f"the first mode, {first_mode_hz:.3g} Hz, lies above what the motion excites, {band:.3g} Hz: "
            "record a chirp that sweeps well beyond it."
        )
    fastest = None if stiffest is None else stiffest * band
    return FitProblem(recording, sensors=sensors, rigid=rigid, band_hz=band, stiffest_hz=fastest)


def started_values(problem: FitProblem, keys: Sequence[str], *, first_mode_hz: float | None = None) -> dict[str, float]:
    """Values of the base keys from which the fit converges."""
    if problem.rigid:
        return rigid_start(problem, [k for k in keys if k in RIGID_KEYS])
    start = scanned_start(problem, first_mode_hz=first_mode_hz)
    return {k: start.get(k, 0.0) for k in keys if k in FLEXIBLE_KEYS}


def refined(
    solver: SimulationFit, keys: Sequence[str], start: Mapping[str, float], *, progress: Progress | None = None
) -> Fit:
    """The fit over `keys`: three rounds, the whitening filter taken anew from the residual before each.

    Raises ExcitationError when the simulation runs away.
    """
    values: Mapping[str, float] = start
    rounds = ((12, 1e-3), (12, 1e-5), (25, 1e-9))
    fit: Fit | None = None
    for i, (iterations, tolerance) in enumerate(rounds):
        if not all(np.isfinite(r).all() for r in solver.problem.residuals(values)):
            raise ExcitationError("no spring in the excited band explains the torque: the simulated link runs away.")
        fit = solver.solve(keys, values, solver.whitenings(values), iterations=iterations, tolerance=tolerance)
        values = fit.values
        if progress is not None:
            progress((i + 1) / len(rounds))
    assert fit is not None
    return fit


def estimated(
    problem: FitProblem,
    base_keys: Sequence[str],
    start: Mapping[str, float],
    *,
    priors: Mapping[str, Prior] | None = None,
    progress: Progress | None = None,
) -> Estimate:
    """Maximum likelihood over `base_keys` and the measurement keys, with uncertainty and a held-out check."""
    nuisances = dict(measurement_priors(problem) if priors is None else priors)
    keys = (*base_keys, *nuisances)

    def part(low: float, high: float) -> Progress:
        return lambda x: progress(low + x * (high - low)) if progress is not None else None

    fit = refined(SimulationFit(problem, priors=nuisances), keys, start, progress=part(0.0, 0.8))
    validation = validation_blocks(problem)
    trained = SimulationFit(problem.restricted(problem.usable & ~validation), priors=nuisances).solve(
        keys, fit.values, fit.whitenings, iterations=6, tolerance=1e-6
    )
    part(0.8, 1.0)(1.0)
    return Estimate(problem, fit, uncertainty_of(fit, problem.rate_hz), validation, trained.values)
