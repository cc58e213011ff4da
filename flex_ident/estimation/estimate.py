"""From a recording to the maximum-likelihood fit: start, whitening, refinement; and what it did not see."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import ndimage

from flex_ident.errors import ExcitationError, UsageError
from flex_ident.estimation.base_fit import Progress, base_fit
from flex_ident.estimation.chain_known import with_chain_open
from flex_ident.estimation.effort_cut import cut_covariance, cut_notice
from flex_ident.estimation.effort_kind import resolved
from flex_ident.estimation.encoder_rounding import rounding_bias
from flex_ident.estimation.far_mode import unseen_shift
from flex_ident.estimation.kind_fit import KindFit
from flex_ident.estimation.kind_priors import base_priors, kept_priors
from flex_ident.estimation.link_turnover import turnover_shift
from flex_ident.estimation.other_end import OtherEnd, other_end
from flex_ident.estimation.strain import material, strained_factor
from flex_ident.estimation.thresholds import (
    BAND_IN_MODES,
    LARGEST_BAND,
    LEAST_PERIODS,
    SURE_OF_MODE,
    WIDE_HZ,
)
from flex_ident.estimation.unseen_effects import unseen_covariance, unseen_stds
from flex_ident.estimation.unseen_of_rigid import gear_covariance
from flex_ident.estimation.unseen_spring import spring_shift
from flex_ident.filtering.band import excited_band_hz
from flex_ident.filtering.frequency_response import first_mode
from flex_ident.judgement.priorities import LOADED, REVERSED, apart_in_time
from flex_ident.likelihood.covariance import Uncertainty, uncertainty_of
from flex_ident.likelihood.fit import Fit, Prior
from flex_ident.likelihood.nuisances import strained
from flex_ident.likelihood.problem import Bools, FitProblem
from flex_ident.likelihood.remainder import Remainder, remainder
from flex_ident.likelihood.start import drives, scanned_start
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Code, Notice
from flex_ident.parameters import FLEXIBLE_KEYS, GRAVITY_KEYS, RIGID_KEYS
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats, Recording
from flex_ident.regression.gravity import shows_gravity
from flex_ident.screening.coupling import Coupling, coupling_of
from flex_ident.screening.suspects import Suspect, suspects, widened

VALIDATION_BLOCK_S = 1.0
VALIDATION_EVERY = 4
LATEST_S, SHIFTS, LATE_LEFT = 0.06, 61, 0.8
"""How far apart torque and position are tried, s, in how many steps; the share of the squares left then, to say so."""
CORRELATED_S = 0.5
"""Time over which residuals count as correlated when gravity is looked for, s."""


@dataclass(frozen=True)
class Estimate:
    """A fit with its uncertainty, and the same keys fitted without the validation part."""

    problem: FitProblem
    solver: SteadyFit
    fit: Fit
    uncertainty: Uncertainty
    validation: Bools
    """Where (m,) the fit `trained` did not look."""
    trained: Values
    left: Remainder
    suspects: tuple[Suspect, ...]
    plain: Uncertainty
    """The uncertainty as if the model were right; `uncertainty` is joined with what suspects would move."""
    strained: tuple[str, ...] = ()
    """Nuisances of the measurement chain at the end of what they can be, where that bears on the joint."""
    coupling: Coupling | None = None
    """What the motion of other joints explains of what is left; None where none moved."""
    unseen: Mapping[str, float] = field(default_factory=dict)
    """Standard deviation of a key for effects on the link that may be there unseen (`unseen_effects`)."""
    lossy: Mapping[str, float] = field(default_factory=dict)
    """The same for a loss of the spring."""
    eccentric: Mapping[str, float] = field(default_factory=dict)
    """The same for an error of the link's encoder."""
    other: OtherEnd | None = None
    """Where another start ended that is as likely; None where there is none."""
    steps: Notice | None = None
    """That the effort may have been cut toward zero, where that is a part of an interval (`effort_cut`)."""
    kind: KindFit | None = None
    """Which kind of effort the fit is of, where that was asked."""


def validation_blocks(problem: FitProblem) -> Bools:
    """Every fourth second of the decimated clock (m,): the part that a validation keeps from the fit."""
    block = np.floor(problem.time / VALIDATION_BLOCK_S).astype(int)
    held: Bools = (block % VALIDATION_EVERY) == VALIDATION_EVERY - 1
    return held & problem.usable


def rigid_keys(problem: FitProblem, *, gravity: bool) -> tuple[str, ...]:
    """Base keys of a rigid joint: MX and MY where `gravity` may act and the recording shows it."""
    plain = tuple(k for k in RIGID_KEYS if k not in GRAVITY_KEYS)
    if not gravity:
        return plain
    names = (*plain, *GRAVITY_KEYS)
    matrix, target = _rigid_columns(problem, names), problem.torque[problem.usable]
    lag = max(1, min(round(CORRELATED_S * problem.rate_hz), target.size // 20))
    held = validation_blocks(problem)[problem.usable]
    return names if shows_gravity(matrix, target, names, held, lag) else plain


def _rigid_columns(problem: FitProblem, keys: Sequence[str]) -> Floats:
    """What one unit of each key adds to the torque at the usable samples, (r, p)."""
    return np.column_stack([problem.prediction(Values({key: 1.0})).torque[problem.usable] for key in keys])


def rigid_start(problem: FitProblem, keys: Sequence[str]) -> Values:
    """Linear least squares of a rigid joint's base keys: the start of its fit. Raises ExcitationError."""
    columns = _rigid_columns(problem, keys)
    values, _ = _rigid_values(columns, keys, problem.torque[problem.usable])
    if values.get("J", 1.0) <= 0.0:
        raise ExcitationError(f"the inertia comes out negative: {_why_negative(problem, keys, columns)}")
    return values | {k: max(v, 0.0) for k, v in values.items() if k in ("FV", "FS")}


def _rigid_values(columns: Floats, keys: Sequence[str], torque: Floats) -> tuple[Values, float]:
    """What least squares gives the keys of columns (m, p), and the sum of squares that it leaves of the torque (m,)."""
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    solution, *_ = np.linalg.lstsq(columns / scale, torque, rcond=1e-8)
    left = torque - columns / scale @ solution
    return Values().with_vector(keys, solution / scale), float(left @ left)


def _why_negative(problem: FitProblem, keys: Sequence[str], columns: Floats) -> str:
    """Why a rigid joint's inertia comes out negative: sign or time of the torque, or what else moves."""
    if not drives(problem):
        return REVERSED
    if any(notice.code is Code.OTHER_JOINTS_MOVE for notice in problem.recording.notices):
        return LOADED
    _, least = _rigid_values(columns, keys, problem.torque[problem.usable])
    best, least = 0.0, LATE_LEFT * least
    for late in np.linspace(-LATEST_S, LATEST_S, SHIFTS).tolist():
        torque = ndimage.shift(problem.torque, -late * problem.rate_hz, order=3, mode="nearest")[problem.usable]
        values, left = _rigid_values(columns, keys, torque)
        if left < least and all(values.get(key, 1.0) > 0.0 for key in ("J", "FV", "FS")):
            best, least = late, left
    return apart_in_time(best) if best else LOADED


def fit_problem(
    recording: Recording,
    *,
    sensors: str,
    rigid: bool = False,
    first_mode_hz: float | None = None,
    stiffest: float | None = None,
    band_hz: float | None = None,
) -> FitProblem:
    """The problem over `band_hz`, or the band that the recording excites; `stiffest` is the fastest mode to integrate,
    in bands.

    Raises ExcitationError, and UsageError on a band that the recording's rate or length cannot hold.
    """
    if band_hz is not None:
        rate, n = recording.sample_rate_hz, recording.motor_position.size
        lowest, highest = LEAST_PERIODS * rate / n, LARGEST_BAND * rate
        if not lowest < band_hz <= highest:
            raise UsageError(
                f"--band {band_hz:g} Hz: this recording can be fitted up to between {lowest:.2g} and {highest:.4g} Hz."
            )
    band = band_hz if band_hz is not None else excited_band_hz(recording)
    if band_hz is None and not rigid and band > WIDE_HZ:
        mode = first_mode(recording, hint_hz=first_mode_hz)
        if mode.confidence > SURE_OF_MODE:
            band = min(band, BAND_IN_MODES * mode.free_resonance_hz)
    if first_mode_hz is not None and first_mode_hz > 1.5 * band and not rigid:
        raise ExcitationError(
            f"the first mode, {first_mode_hz:.3g} Hz, lies above what the motion excites, {band:.3g} Hz: "
            "record a chirp that sweeps well beyond it."
        )
    fastest = None if stiffest is None else stiffest * band
    return FitProblem(recording, sensors=sensors, rigid=rigid, band_hz=band, stiffest_hz=fastest)


def started_values(problem: FitProblem, keys: Sequence[str], *, first_mode_hz: float | None = None) -> Values:
    """Values of the base keys from which the fit converges; without Jm among them the effort is a joint sensor's."""
    if problem.rigid:
        return rigid_start(problem, [k for k in keys if k in RIGID_KEYS])
    start = scanned_start(problem, first_mode_hz=first_mode_hz, motor="Jm" in keys)
    return Values({k: start.get(k, 0.0) for k in keys if k in FLEXIBLE_KEYS})


def estimated(
    problem: FitProblem,
    base_keys: Sequence[str],
    start: Values,
    *,
    priors: Mapping[str, Prior] | None = None,
    prismatic: bool = False,
    kind: str = "motor",
    progress: Progress | None = None,
) -> Estimate:
    """Maximum likelihood over `base_keys` and the nuisances, with uncertainty and a held-out check.

    `kind`: what the effort is; `auto` finds out, which may change the keys.
    """
    nuisances = base_priors(problem, base_keys, kind) if priors is None else kept_priors(priors, base_keys)

    def part(low: float, high: float) -> Progress:
        return lambda x: progress(low + x * (high - low)) if progress is not None else None

    solver, fit = base_fit(problem, base_keys, start, nuisances, progress=part(0.0, 0.8))
    kinds = resolved(solver.problem, solver, fit, kind)
    found = of_kind(estimate_of(kinds.solver, kinds.fit, prismatic=prismatic), kinds)
    part(0.8, 1.0)(1.0)
    return found


def of_kind(estimate: Estimate, kinds: KindFit) -> Estimate:
    """The estimate with what is known of its effort; a kind that cannot be ruled out is in its uncertainty."""
    own = kinds.refitted(estimate.solver, estimate.fit).weighed(estimate.uncertainty)
    return replace(estimate, kind=own, uncertainty=own.joined(estimate.uncertainty))


def estimate_of(solver: SteadyFit, fit: Fit, *, prismatic: bool = False) -> Estimate:
    """A fit with its uncertainty, fitted again without the validation part, and what may be missing."""
    problem = solver.problem
    validation = validation_blocks(problem)
    own = SteadyFit(problem.restricted(problem.usable & ~validation), priors=solver.priors, marks=solver.marks)
    trained = own.solve(fit.free, fit.values, fit.whitenings, iterations=6, tolerance=1e-6)
    plain, left = uncertainty_of(fit, problem.rate_hz), remainder(solver, fit)
    found = suspects(solver, fit, left, prismatic=prismatic)
    joined, ends = widened(plain, found, left), strained(fit.values, solver.priors)
    if left.structured(left.gap) or any(suspect.strong for suspect in found):
        joined = joined.beside(unseen_shift(solver, fit))
    joined = joined.beside(spring_shift(solver, fit)).beside(turnover_shift(solver, fit))
    joined = joined.beside(rounding_bias(solver, fit))
    other = other_end(fit, plain)
    joined = with_chain_open(joined, plain, fit.values, problem.recording.sample_time)
    bent, eccentric = unseen_covariance(solver, fit, "measurement"), {}
    if bent is not None:
        joined = replace(joined, covariance=joined.covariance + bent)
        eccentric = dict(zip(fit.free, map(float, np.sqrt(np.maximum(np.diag(bent), 0.0))), strict=True))
    cut, lost = cut_covariance(solver, fit), gear_covariance(solver, fit)
    joined = replace(joined, covariance=joined.covariance + cut + (0.0 if lost is None else lost))
    joined = joined.beside(None if other is None else other.shift)
    matter = material(fit, ends, plain)
    if left.link is not None and left.link.structured and not left.structured(left.gap):
        # All of it goes into the spring that the encoder sits behind, little into what the torque tells.
        factor = left.link.gap / max(left.link.floor, 1e-300)
        size = np.array([factor if key == "K" else math.sqrt(factor) for key in fit.free])
        joined = replace(joined, covariance=joined.covariance + (np.outer(size, size) - 1.0) * plain.covariance)
    if ends and not left.structured(left.gap):  # something is at work, and nothing shows what it does to the parameters
        factor = strained_factor(ends, matter)
        joined = replace(joined, covariance=joined.covariance + (factor**2 - 1.0) * plain.covariance)
    coupling = coupling_of(solver, fit)
    unseen, lossy = (unseen_stds(solver, fit, where) for where in ("link", "spring"))
    known = (trained.values, left, found, plain, matter, coupling, unseen, lossy, eccentric, other)
    return Estimate(
        problem, solver, fit, joined, validation, *known, steps=cut_notice(problem.recording, cut, joined.covariance)
    )
