"""The search: one missing effect at a time, until what is left is noise or nothing in the catalogue explains it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from flex_ident.effects import CATALOGUE, effect_named
from flex_ident.errors import DataError, ExcitationError
from flex_ident.estimation.fit import Fit
from flex_ident.gap.candidates import Candidate, candidates
from flex_ident.gap.explanation import Rejected, Untestable
from flex_ident.gap.fitting import GapFit
from flex_ident.gap.options import GapOptions
from flex_ident.gap.screening import TESTABLE, Score, scores
from flex_ident.gap.trials import Trial, excess_of, final_polish, tried

Progress = Callable[[float, str], None]
MOST_EFFECTS = 4
MOST_TRIALS = 4
SHAPED = ("second_mode",)
"""Effects whose refit races from several shapes."""
WORTH_A_TRIAL = 12.0
"""Twice the log-likelihood that screening must promise."""
QUIET = 0.15
"""Excess over the noise under which a second mode is not searched for deeply."""
NEAR_TIE = 6.0
"""Difference of the BIC under which two effects cannot be told apart."""


@dataclass(frozen=True)
class Accepted:
    """One round of the search that ended with an effect in the model."""

    trial: Trial
    by_hand: bool
    before: Fit
    others: tuple[Trial, ...]
    """The other candidates of the round, best first."""

    @property
    def ties(self) -> tuple[str, ...]:
        """Effects that the data cannot tell from the accepted one."""
        near = (t for t in self.others if self.trial.evidence - t.evidence < NEAR_TIE and t.effect != self.trial.effect)
        return tuple(dict.fromkeys(t.effect for t in near))


@dataclass
class Search:
    """Where the search stands: the model's fit, what was accepted and what was not."""

    solver: GapFit
    fit: Fit
    accepted: list[Accepted] = field(default_factory=list)
    rejected: dict[str, Rejected] = field(default_factory=dict)
    untestable: dict[str, Untestable] = field(default_factory=dict)


def searched(solver: GapFit, base: Fit, options: GapOptions, progress: Progress) -> Search:
    """The search from a base fit. Raises DataError when an effect that was asked for cannot be added."""
    search = Search(solver, base)
    for name in options.add:
        search = _added_by_hand(search, name, options)
    for round_number in range(MOST_EFFECTS):
        share = round_number / MOST_EFFECTS
        progress(share, "screening")
        found = _scored(search, options)
        trials = _trials(search, found, options, partial(_part, progress, share))
        best = next((t for t in trials if not t.objection), None)
        for t in trials:
            if t is not best and t.objection:
                search.rejected[t.effect] = Rejected(t.effect, max(0.0, t.share), t.objection)
        if best is None:
            break
        search.rejected.pop(best.effect, None)
        others = tuple(t for t in trials if t is not best)
        search.accepted.append(Accepted(best, False, search.fit, others))
        search.solver = best.solver
        search.fit = final_polish(best.solver, best.fit)
    progress(1.0, "searched")
    return search


def _part(progress: Progress, start: float, share: float, text: str) -> None:
    progress(start + share / MOST_EFFECTS, text)


def _scored(search: Search, options: GapOptions) -> list[Score]:
    tries = list(candidates(search.solver.problem, search.fit.values, options))
    found = scores(search.solver, search.fit, tries)
    kept = []
    for score in found:
        name = score.candidate.effect
        if score.orthogonal >= TESTABLE:
            kept.append(score)
            search.untestable.pop(name, None)
        elif all(s.candidate.effect != name for s in kept):
            effect = effect_named(name)
            search.untestable[name] = Untestable(name, score.orthogonal, effect.separated_by)
    promising = {s.candidate.effect for s in kept}
    for s in kept:
        if s.gain < WORTH_A_TRIAL and s.candidate.effect not in search.rejected:
            reason = "it would explain nothing of what is left"
            search.rejected[s.candidate.effect] = Rejected(s.candidate.effect, 0.0, reason)
    for name in list(search.untestable):
        if name in promising:
            del search.untestable[name]
    return kept


def _trials(search: Search, found: list[Score], options: GapOptions, progress: Progress) -> list[Trial]:
    """Refits of the best few, best first."""
    chosen = [s for s in found if s.gain >= WORTH_A_TRIAL][:MOST_TRIALS]
    names = {s.candidate.effect for s in chosen}
    loud = excess_of(search.solver, search.fit) > QUIET
    late = [s for s in found if s.candidate.effect == "second_mode" and loud and "second_mode" not in names]
    shapes: dict[str, list[Candidate]] = {}
    for candidate in candidates(search.solver.problem, search.fit.values, options):
        shapes.setdefault(candidate.effect, []).append(candidate)
    trials: list[Trial] = []
    for i, score in enumerate([*chosen, *late]):
        name = score.candidate.effect
        if score in late and any(t.share > 0.5 and not t.objection for t in trials):
            continue
        progress(0.2 + 0.8 * i / (len(chosen) + len(late)), f"trying {name.replace('_', ' ')}")
        others = _spread(shapes[name]) if name in SHAPED and loud else ()
        try:
            trials.append(tried(search.solver, search.fit, score, tried_effects=len(CATALOGUE), alternatives=others))
        except ExcitationError:
            continue
    return sorted(trials, key=lambda t: -t.evidence)


def _spread(shapes: list[Candidate]) -> list[Candidate]:
    """The shapes to race from: what the link's motion shows, and one inertia at each frequency of the grid."""
    odd = len(shapes) % 2
    return [*shapes[:odd], *shapes[odd::2]]


def _added_by_hand(search: Search, name: str, options: GapOptions) -> Search:
    """The search with an effect put in, whatever speaks against it. Raises DataError."""
    own = GapOptions(sensors=options.sensors, rigid=options.rigid, without=options.without, effects=(name,))
    tries = list(candidates(search.solver.problem, search.fit.values, own))
    found = scores(search.solver, search.fit, tries)
    if not found:
        raise DataError(f"--add {name}: makes no sense for this joint, or is part of the model already.")
    trial = tried(search.solver, search.fit, found[0], tried_effects=1)
    search.accepted.append(Accepted(trial, True, search.fit, ()))
    search.solver, search.fit = trial.solver, final_polish(trial.solver, trial.fit)
    return search
