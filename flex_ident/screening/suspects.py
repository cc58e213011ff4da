"""What could be behind what a model leaves, and how far each would move the model's parameters.

A missing effect does not only leave a residual: what the model can imitate of it goes into the parameters. So for each
effect of the catalogue the parameters are followed along, to first order, or by a rough refit where it promises much.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flex_ident.effects import CATALOGUE
from flex_ident.errors import ExcitationError
from flex_ident.likelihood.comparison import correlation_factor
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.remainder import Remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.recording import Floats
from flex_ident.screening.candidates import candidates
from flex_ident.screening.scoring import Score, scores
from flex_ident.screening.sketching import sketched
from flex_ident.screening.thresholds import LEAST_WEIGHT, NO_CAUSE, STRONG

MOST_SKETCHES = 4


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
    def strong(self) -> bool:
        """Whether the recording speaks for it beyond all doubt of chance."""
        return self.gain > STRONG


def suspects(solver: SteadyFit, fit: Fit, *, prismatic: bool = False, structured: bool = False) -> tuple[Suspect, ...]:
    """Every effect of the catalogue that the residual speaks for; most first.

    Under the weights of the fit, which let bad stretches weigh little. Where what is left is `structured` and none
    stands out, under the steady noise's as well, in which an effect that lies in one stretch shows.
    """
    found = _suspects(solver, fit, prismatic=prismatic)
    if structured and not any(s.strong for s in found):
        steady = SteadyFit(solver.problem, priors=solver.priors, marks=solver.marks)
        there = steady.linearised(fit.free, fit.values, steady.whitenings(fit.values), fit.at_bound)
        found = _merged(found, _suspects(steady, there, prismatic=prismatic))
    return tuple(sorted(found, key=lambda s: -s.gain))


def _merged(one: list[Suspect], two: list[Suspect]) -> list[Suspect]:
    best: dict[str, Suspect] = {}
    for suspect in (*one, *two):
        known = best.get(suspect.effect)
        if known is None or suspect.gain > known.gain:
            best[suspect.effect] = suspect
    return list(best.values())


def _suspects(solver: SteadyFit, fit: Fit, *, prismatic: bool) -> list[Suspect]:
    tries = candidates(solver.problem, fit.values, prismatic=prismatic)
    correlated = correlation_factor(fit)
    count = fit.residual.size / correlated
    found: list[Suspect] = []
    scored = [s for s in scores(solver, fit, tries) if s.shift is not None]
    for score in scored:
        price = len(score.candidate.keys) * math.log(count) + 2.0 * math.log(len(CATALOGUE))
        assert score.shift is not None
        # No larger than anything that somebody would have overlooked.
        within = min(1.0, score.candidate.plausible / max(max(map(abs, score.sizes)), 1e-300))
        found.append(Suspect(score.candidate.effect, score.gain / correlated - price, within * score.shift))
    strong = [(s, score) for s, score in zip(found, scored, strict=True) if s.strong][:MOST_SKETCHES]
    for suspect, score in strong:
        found[found.index(suspect)] = _refitted(solver, fit, score, suspect, correlated)
    return found


def _refitted(solver: SteadyFit, fit: Fit, score: Score, suspect: Suspect, correlated: float) -> Suspect:
    """The suspect after a rough refit. Where that saves nothing the linear estimate was wrong, of its shift too: what
    is left is the price of its parameters."""
    price = score.gain / correlated - suspect.gain
    try:
        there = sketched(solver, fit, score)
    except ExcitationError:
        return replace(suspect, gain=-price)
    saved = 2.0 * (fit.cost - there.cost) / correlated
    if not saved > 0.0:
        return replace(suspect, gain=-price)
    shift = np.array([there.values.get(k, fit.values[k]) - fit.values[k] for k in fit.free])
    rows = solver.problem.usable
    gap = float(np.sqrt(np.mean(solver.problem.residuals(there.values)[0][rows] ** 2)))
    return Suspect(suspect.effect, saved - price, shift, gap)


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
        moved = weight * suspect.shift
        covariance += np.outer(moved, moved)
    unexplained = unexplained_gap(found, left)
    factor = 1.0
    if left.evidence == "none":
        factor = NO_CAUSE
    if left.structured(unexplained) and left.floor > 0.0:
        accounted = (left.gap**2 - unexplained**2) / max(left.gap**2 - left.floor**2, 1e-300)
        factor = unexplained / left.floor * (NO_CAUSE if accounted < 0.5 else 1.0)
    return replace(uncertainty, covariance=covariance + (factor**2 - 1.0) * uncertainty.covariance)


def unexplained_gap(found: tuple[Suspect, ...], left: Remainder) -> float:
    """Gap, N m rms, that is left beside the suspect that leaves least."""
    return min((s.gap for s in found if s.gap is not None and s.strong), default=left.gap)


def named_shift(suspect: Suspect, free: tuple[str, ...]) -> Mapping[str, float]:
    """What a suspect would change, by key."""
    return dict(zip(free, map(float, suspect.shift), strict=True))
