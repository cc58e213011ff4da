"""Effects as other recordings of the joint have them, tried on one that had no part in finding their values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flex_ident.effects import CATALOGUE, effect_named
from flex_ident.effects.probe import Probe
from flex_ident.errors import ExcitationError
from flex_ident.estimation.estimate import fit_problem, validation_blocks
from flex_ident.estimation.gravity_share import with_gravity_told
from flex_ident.estimation.identification import chosen_sensors
from flex_ident.estimation.kind_priors import as_told
from flex_ident.gap.base import fitted_base, search_start
from flex_ident.gap.final import trained_values
from flex_ident.gap.options import GapOptions
from flex_ident.gap.sizes import gap_size
from flex_ident.gap.thresholds import CARRIED_T
from flex_ident.likelihood.comparison import held_out_comparison
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters.keys import key_parts
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording
from flex_ident.screening.candidates import Candidate
from flex_ident.screening.sketching import extended_solver, raced

Outcome = Literal["confirms", "contradicts", "cannot_tell"]
ROUNDS, SETTLED = 4, 0.05
"""Rounds of a fit with the noise taken anew, and the share of what is left that the last one moves at most."""
ITERATIONS, TOLERANCE = 10, 1e-5
TURNS = 4
"""Turns of an angle from which a fit may start: where the motor's position is zero may differ between recordings."""


@dataclass(frozen=True)
class Carried:
    """An effect whose `values` come from elsewhere; those in `free` are only where a fit starts."""

    effect: str
    values: Values
    free: tuple[str, ...] = ()

    @property
    def candidate(self) -> Candidate:
        """The effect as the search would add it."""
        return Candidate(self.effect, Probe((self.values.effects.get(self.effect, {}),), ()))


@dataclass(frozen=True)
class CarriedStep:
    """What one effect does to the recording: gap, N m rms, on data not fitted, before and after.

    `t` is that of the cost which it saves over blocks of time, negative where it costs. `stays`: it is in the model of
    the steps behind it.
    """

    effect: str
    before: float
    after: float
    t: float
    stays: bool

    @property
    def outcome(self) -> Outcome:
        """What the recording says of the effect as others have it."""
        if self.after < self.before and self.t >= CARRIED_T:
            return "confirms"
        return "contradicts" if self.after > self.before and self.t <= -CARRIED_T else "cannot_tell"


@dataclass(frozen=True)
class CarriedOver:
    """The gap of the base, N m rms, and what each effect that was carried over does, one on top of the other."""

    base: float
    steps: tuple[CarriedStep, ...]

    @property
    def after(self) -> float:
        """The gap with all that stays, N m rms."""
        return next((s.after for s in reversed(self.steps) if s.stays), self.base)


def carried_over(
    recording: Recording, options: GapOptions, own: Sequence[Carried], carried: Sequence[Carried], *,
    starts: Sequence[Values] = (), all_stay: bool = False,
) -> CarriedOver:  # fmt: skip
    """Try effects on a recording, their values as they are given and the base model fitted to the recording.

    `own` are effects of the recording itself, all of whose values are fitted: they are in the base. An effect that the
    recording contradicts is taken out again before the next, unless `all_stay`. `starts` are base values from which a
    fit may start as well. Raises ExcitationError.
    """
    sensors = chosen_sensors(recording, options.sensors)
    recording, kind = as_told(*with_gravity_told(recording, options.effort_kind, sensors, rigid=options.rigid))
    names = tuple(c.effect for c in (*own, *carried))
    options = replace(options, effort_kind=kind, effects=names, add=(), staying=() if names else tuple(CATALOGUE))
    problem = fit_problem(
        recording, sensors=sensors, rigid=options.rigid,
        first_mode_hz=options.first_mode_hz, band_hz=options.band_hz,
    )  # fmt: skip
    held = validation_blocks(problem)
    kinds = fitted_base(problem, options).kinds
    solver, fit = search_start(problem, kinds.solver, kinds.fit)
    for effect in own:
        solver, fit = _with(solver, fit, effect, starts)
    gap = base = _gap(solver, fit, problem, held)
    steps: list[CarriedStep] = []
    for effect in carried:
        try:
            after_solver, after = _with(solver, fit, effect, starts)
            seen = after_solver.linearised(after.free, after.values, fit.whitenings, after.at_bound)
        except ExcitationError:  # with that value nothing can be simulated: as far from the measurement as can be
            steps.append(CarriedStep(effect.effect, gap, math.inf, -math.inf, stays=False))
            continue
        t = held_out_comparison(after_solver.problem, fit, seen).t
        own_gap = _gap(after_solver, after, problem, held)
        step = CarriedStep(effect.effect, gap, own_gap, t, stays=True)
        if not all_stay and step.outcome == "contradicts":
            step = replace(step, stays=False)
        else:
            solver, fit, gap = after_solver, after, own_gap
        steps.append(step)
    return CarriedOver(base, tuple(steps))


def _gap(solver: SteadyFit, fit: Fit, problem: FitProblem, held: NDArray[np.bool_]) -> float:
    return gap_size(problem, trained_values(solver, fit, problem, held), held).torque


def _with(solver: SteadyFit, fit: Fit, effect: Carried, starts: Sequence[Values]) -> tuple[SteadyFit, Fit]:
    """The fit with one more effect, only its `free` keys fitted. Raises ExcitationError."""
    candidate = effect.candidate
    extended, keys = extended_solver(solver, fit.free, candidate)
    keys = tuple(k for k in keys if k not in effect.values or k in effect.free)
    zero = {candidate.replaces: 0.0} if candidate.replaces else {}
    near = [fit.values, *(fit.values | own.only(keys) for own in starts)]
    tries = [own | effect.values | zero for own in near]
    angles = [k for k in effect.free if effect_named(effect.effect).parameter(key_parts(k)[1]).angle]
    if angles:
        turns = [2.0 * math.pi * i / TURNS for i in range(TURNS)]
        tries = [own | {k: own[k] + turn for k in angles} for own in tries for turn in turns]
    found = raced(extended, keys, tries, fit)
    for _ in range(ROUNDS):  # under the noise that it leaves itself, which may be far less than what was there before
        left = extended.problem.residuals(found.values)[0]
        whitenings = extended.whitenings(found.values)
        found = extended.finished(keys, found.values, whitenings, iterations=ITERATIONS, tolerance=TOLERANCE)
        now = extended.problem.residuals(found.values)[0]
        if float(np.std(now - left)) < SETTLED * float(np.std(now)):
            break
    return extended, found
