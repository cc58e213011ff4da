"""What could be behind what a model leaves, and how far each would move the model's parameters.

A missing effect does not only leave a residual: what the model can imitate of it goes into the parameters. So for each
effect of the catalogue the parameters are followed along, to first order, or by a rough refit where it promises much.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flex_ident.effects import CATALOGUE, effect_named
from flex_ident.errors import ExcitationError
from flex_ident.likelihood.comparison import correlation_factor
from flex_ident.likelihood.covariance import Uncertainty, uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.remainder import Remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.parameters import UNITS
from flex_ident.recording import Floats
from flex_ident.screening.candidates import Candidate, candidates
from flex_ident.screening.scoring import Score, scores
from flex_ident.screening.sketching import extended_solver, raced, raced_starts, sketched
from flex_ident.screening.thresholds import ENOUGH, LEAST_WEIGHT, NO_CAUSE, SHOWS, STRONG

MOST_SKETCHES = 4
MOST_WEIGHTY, WEIGHTY = 2, 1.0
"""Suspects that are refitted for what they would move, at most, and from how many standard deviations."""
FURTHER = 12
"""Iterations by which the likeliest suspect is refitted further, and the winner of a race."""


@dataclass(frozen=True)
class Suspect:
    """An effect that may be missing: `gain`, twice the log-likelihood in independent samples less the price of its
    parameters; `shift` (p,), what it would change in the free values; `gap`, N m rms, what it would leave of the torque
    (None where it was not refitted)."""

    effect: str
    gain: float
    shift: Floats
    gap: float | None = None

    @property
    def weight(self) -> float:
        """Probability that the effect is there, against the model without it, by the Bayesian information criterion."""
        return 1.0 / (1.0 + math.exp(-0.5 * float(np.clip(self.gain, -60.0, 60.0))))

    @property
    def scales_torque(self) -> float:
        """The factor by which all forces may follow it further than its law says; 0 where they do not follow it."""
        effect = CATALOGUE.get(self.effect)
        return 0.0 if effect is None else effect.scales_torque

    @property
    def strong(self) -> bool:
        """Whether the recording speaks for it beyond all doubt of chance."""
        return self.gain > STRONG


def suspects(solver: SteadyFit, fit: Fit, left: Remainder, *, prismatic: bool = False) -> tuple[Suspect, ...]:
    """Every effect of the catalogue that the residual speaks for; most first.

    Under the weights of the fit, which let bad stretches weigh little. Where what is `left` is structured and none
    stands out, under the steady noise's as well, in which an effect that lies in one stretch shows. Where it is
    structured or one stands out, what has many minima is raced where it may be the cause, and the likeliest is refitted
    further.
    """
    found, structured = _screened(solver, fit, prismatic=prismatic), left.structured(left.gap)
    if structured and not any(t.suspect.strong for t in found):
        steady = SteadyFit(solver.problem, priors=solver.priors, marks=solver.marks)
        there = steady.linearised(fit.free, fit.values, steady.whitenings(fit.values), fit.at_bound)
        found = _merged(found, _screened(steady, there, prismatic=prismatic))
    if found and (structured or any(t.suspect.strong for t in found)):
        found = _looked_into(found, left, prismatic=prismatic)
    found = _merged(found, _stood_in_for(solver, fit, prismatic=prismatic))
    return tuple(sorted((t.suspect for t in found if t.score.shift is not None or t.there), key=lambda s: -s.gain))


@dataclass(frozen=True)
class _Tried:
    """A suspect with what it was told from: its score on `fit`, and the rough refit with it where there was one."""

    suspect: Suspect
    score: Score
    solver: SteadyFit
    fit: Fit
    correlated: float
    there: Fit | None = None

    @property
    def price(self) -> float:
        """What the gain must exceed: that of its parameters, and of the choice among all effects."""
        count = self.fit.residual.size / self.correlated
        return len(self.score.candidate.keys) * math.log(count) + 2.0 * math.log(len(CATALOGUE))

    def refitted(self, there: Fit) -> _Tried:
        """The same after a refit. Where that saves nothing the linear estimate was wrong, of its shift too: what is
        left is the price of its parameters."""
        saved = 2.0 * (self.fit.cost - there.cost) / self.correlated
        if not saved > 0.0:
            return self.disproved()
        shift = np.array([there.values.get(k, self.fit.values[k]) - self.fit.values[k] for k in self.fit.free])
        rows = self.solver.problem.usable
        gap = float(np.sqrt(np.mean(self.solver.problem.residuals(there.values)[0][rows] ** 2)))
        return replace(self, suspect=Suspect(self.suspect.effect, saved - self.price, shift, gap), there=there)

    def disproved(self) -> _Tried:
        """The same after a refit that saved nothing, or ran away."""
        return replace(self, suspect=replace(self.suspect, gain=-self.price))

    def sketched(self) -> _Tried:
        """After a rough refit from the linear estimate."""
        try:
            return self.refitted(sketched(self.solver, self.fit, self.score))
        except ExcitationError:
            return self.disproved()

    def raced(self, tried: Iterable[Candidate]) -> _Tried:
        """After a race among the shapes of an effect of many minima, which no linear estimate can tell apart."""
        extended, keys = extended_solver(self.solver, self.fit.free, self.score.candidate)
        starts = raced_starts(self.solver, self.fit, self.score, tried)
        try:
            ahead, noise = raced(extended, keys, starts, self.fit).values, self.fit.whitenings
            there = extended.solve(keys, ahead, noise, iterations=FURTHER, tolerance=1e-3, rough=True)
            found = self.refitted(there)
        except ExcitationError:
            return self
        return found if found.suspect.gain > self.suspect.gain else self

    def continued(self) -> _Tried:
        """After the rough refit went on: what is sketched has not moved the parameters all the way."""
        assert self.there is not None
        extended, keys = extended_solver(self.solver, self.fit.free, self.score.candidate)
        noise = self.fit.whitenings
        try:
            found = extended.solve(keys, self.there.values, noise, iterations=FURTHER, tolerance=1e-4, rough=True)
        except ExcitationError:
            return self
        return self.refitted(found) if found.cost < self.there.cost else self


def _stood_in_for(solver: SteadyFit, fit: Fit, *, prismatic: bool) -> list[_Tried]:
    """What a nuisance that shows may stand for: the effects that it stands in for, and those that are confused with
    them, told from a fit without it, as no small step from the fit with it leads there."""
    known = uncertainty_of(fit, solver.problem.rate_hz)
    shown = {
        n
        for e in CATALOGUE.values() if e.where == "link"
        for n in e.stand_ins if n in fit.free and abs(fit.values[n]) > SHOWS * known.std(n)
    }  # fmt: skip
    if not shown:
        return []
    likely = {n for n, e in CATALOGUE.items() if shown & set(e.stand_ins)}
    likely |= {n for n, e in CATALOGUE.items() if likely & set(e.confused_with)}
    own = SteadyFit(
        solver.problem, priors={k: p for k, p in solver.priors.items() if k not in shown}, marks=solver.marks,
        local=solver.local,
    )  # fmt: skip
    values, keys = fit.values | dict.fromkeys(shown, 0.0), [k for k in fit.free if k not in shown]
    try:
        without = own.solve(keys, values, fit.whitenings, iterations=FURTHER, tolerance=1e-3, rough=True)
    except ExcitationError:
        return []
    tried = [t for t in _screened(own, without, prismatic=prismatic) if t.suspect.effect in likely and t.there]
    ends = [(t, t.continued().there) for t in tried]
    return [replace(t, solver=solver, fit=fit).refitted(there) for t, there in ends if there is not None]


def _merged(one: list[_Tried], two: list[_Tried]) -> list[_Tried]:
    best: dict[str, _Tried] = {}
    for tried in (*one, *two):
        known = best.get(tried.suspect.effect)
        if known is None or tried.suspect.gain > known.suspect.gain:
            best[tried.suspect.effect] = tried
    return list(best.values())


def _screened(solver: SteadyFit, fit: Fit, *, prismatic: bool) -> list[_Tried]:
    """Each effect by its linear estimate, the few that promise most after a rough refit."""
    correlated = correlation_factor(fit)
    found: list[_Tried] = []
    for score in scores(solver, fit, candidates(solver.problem, fit.values, prismatic=prismatic)):
        nothing = Suspect(score.candidate.effect, 0.0, np.zeros(len(fit.free)))
        tried = _Tried(nothing, score, solver, fit, correlated)
        shift = nothing.shift
        if score.shift is not None:
            # No larger than anything that somebody would have overlooked.
            within = min(1.0, score.candidate.plausible / max(max(map(abs, score.sizes)), 1e-300))
            shift = within * score.shift
        gain = score.gain / correlated - tried.price
        found.append(replace(tried, suspect=replace(nothing, gain=gain, shift=shift)))
    strong = [t for t in found if t.suspect.strong]
    # Of what has many minima the linear estimate says less than the refit: it need not compete for its place, nor be
    # strong where what it is mistaken for is.
    named = {t.suspect.effect for t in strong}
    many = [t for t in found if effect_named(t.suspect.effect).raced]
    more = [t for t in many if t.suspect.strong or named & set(effect_named(t.suspect.effect).mistaken_for)]
    likely = (*strong[:MOST_SKETCHES], *more, *_weighty([t for t in found if not t.suspect.strong], fit, solver))
    return [t.sketched() if any(t is s for s in likely) else t for t in found]


def _weighty(found: Sequence[_Tried], fit: Fit, solver: SteadyFit) -> list[_Tried]:
    """The few faults of the measurement that the recording does not speak for beyond doubt which would still move a
    parameter most, and by more than its uncertainty: a drive that gives way at the largest torque was said to scale all
    forces by 2 %, by a linear estimate that no refit bore out.

    Not the joint's own laws, of which a rough refit tells less: without their shifts the bands of friction that has
    another law held it at 56 of 70 speeds.
    """
    found = [t for t in found if effect_named(t.suspect.effect).where == "measurement"]
    known = uncertainty_of(fit, solver.problem.rate_hz)
    std = np.array([known.std(key) for key in fit.free])
    own = np.array([key in UNITS and 0.0 < s < math.inf for key, s in zip(fit.free, std, strict=True)])
    if not own.any():
        return []
    moved = [(t.suspect.weight * float(np.max(np.abs(t.suspect.shift[own]) / std[own])), t) for t in found]
    heavy = sorted((size for size in moved if size[0] > WEIGHTY), key=lambda size: -size[0])
    return [t for _, t in heavy[:MOST_WEIGHTY]]


def _looked_into(found: list[_Tried], left: Remainder, *, prismatic: bool) -> list[_Tried]:
    """The suspects after another look: the likeliest as far as its refit goes; what has many minima, of which no linear
    estimate tells, where the likeliest does not account for nearly all, or where it may pass for it."""
    found = _continued(found)
    for i, tried in enumerate(found):
        if effect_named(tried.suspect.effect).raced and _may_be(tried, found, left):
            shapes = candidates(tried.solver.problem, tried.fit.values, prismatic=prismatic)
            found = [*found[:i], tried.raced(shapes), *found[i + 1 :]]
    return found


def _continued(found: list[_Tried]) -> list[_Tried]:
    """The suspects with the likeliest as far as its refit goes."""
    best = _best(found)
    return [t.continued() if t is best and t.there is not None else t for t in found]


def _may_be(tried: _Tried, found: Sequence[_Tried], left: Remainder) -> bool:
    """Whether an effect of many minima may be the cause, though another is the likeliest."""
    best = _best(found).suspect
    if best.strong and best.effect in effect_named(tried.suspect.effect).mistaken_for:
        return True
    known = [t.suspect for t in found]
    return left.structured(unexplained_gap(known, left)) and accounted(known, left) <= ENOUGH


def _best(found: Sequence[_Tried]) -> _Tried:
    return max(found, key=lambda t: t.suspect.gain)


def widened(uncertainty: Uncertainty, found: tuple[Suspect, ...], left: Remainder) -> Uncertainty:
    """The uncertainty joined with what each suspect would move, as far as it is probable, and what none explains.

    Suspects that do much less than the best one weigh as much less. Structure that remains beside the best of them
    makes every standard deviation larger by its size over the noise.
    """
    covariance = uncertainty.covariance.copy()
    best = max((s.gain for s in found), default=0.0)
    for suspect in found:
        weight = suspect.weight * min(1.0, max(suspect.gain, 0.0) / best if best > STRONG else 1.0)
        if weight < LEAST_WEIGHT:
            continue
        moved = weight * (suspect.scales_torque or 1.0) * suspect.shift
        covariance += np.outer(moved, moved)
    unexplained = unexplained_gap(found, left)
    factor = 1.0
    if left.evidence == "none":
        factor = NO_CAUSE
    if left.structured(unexplained) and left.floor > 0.0:
        factor = unexplained / left.floor * (NO_CAUSE if accounted(found, left) < 0.5 else 1.0)
    return replace(uncertainty, covariance=covariance + (factor**2 - 1.0) * uncertainty.covariance)


def unexplained_gap(found: Sequence[Suspect], left: Remainder) -> float:
    """Gap, N m rms, that is left beside the suspect that leaves least."""
    return min((s.gap for s in found if s.gap is not None and s.strong), default=left.gap)


def accounted(found: Sequence[Suspect], left: Remainder) -> float:
    """Share of the gap above the noise, by energy, for which the suspect that leaves least accounts."""
    return (left.gap**2 - unexplained_gap(found, left) ** 2) / max(left.gap**2 - left.floor**2, 1e-300)


def named_shift(suspect: Suspect, free: tuple[str, ...]) -> Mapping[str, float]:
    """What a suspect would change, by key."""
    return dict(zip(free, map(float, suspect.shift), strict=True))
