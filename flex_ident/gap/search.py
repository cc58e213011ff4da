"""The search: one missing effect at a time, until what is left is noise or nothing in the catalogue explains it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

from flex_ident.effects import effect_named
from flex_ident.errors import DataError, ExcitationError
from flex_ident.gap.explanation import Rejected, Untestable
from flex_ident.gap.options import GapOptions
from flex_ident.gap.thresholds import ENOUGH, MIMICKED, MOST_OF_IT, NEAR_TIE, QUIET, WORTH_A_TRIAL
from flex_ident.gap.trials import (
    Trial,
    closed_share,
    compared,
    deepened,
    excess_of,
    final_polish,
    own_error_of,
    tried,
    without,
)
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.remainder import remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.screening.candidates import Candidate, candidates
from flex_ident.screening.scoring import Score, scores
from flex_ident.screening.sketching import best_start, effects_in, sketched, starts_of
from flex_ident.screening.thresholds import VISIBLE

Progress = Callable[[float, str], None]
MOST_EFFECTS, MOST_ROUNDS = 4, 8
"""Different effects that are accepted at most, and rounds: a harmonic each."""
MOST_TRIALS, MOST_TRIALS_IN_VAIN = 4, 8
"""Sketches that are finished, and how many while something speaks against each."""


RUNS_AWAY = "its simulation runs away, whatever shape it starts from"


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
        rivals = (t for t in self.others if t.effect != self.trial.effect and not t.objection)
        return tuple(dict.fromkeys(t.effect for t in rivals if self.trial.evidence - t.evidence < NEAR_TIE))


@dataclass
class Search:
    """Where the search stands: the model's fit, what was accepted and what was not."""

    solver: SteadyFit
    base: Fit
    fit: Fit
    accepted: list[Accepted] = field(default_factory=list)
    rejected: dict[str, Rejected] = field(default_factory=dict)
    untestable: dict[str, Untestable] = field(default_factory=dict)

    def after(self, index: int) -> Fit:
        """The fit after the accepted effect of that index."""
        return self.accepted[index + 1].before if index + 1 < len(self.accepted) else self.fit

    def own_error(self, besides: Accepted | None = None) -> float:
        """By how much the model may be wrong itself, one of its effects left aside."""
        steps = [(a.trial.effect, a.before, self.after(i)) for i, a in enumerate(self.accepted) if a is not besides]
        return own_error_of(self.solver, steps)


def searched(solver: SteadyFit, base: Fit, options: GapOptions, progress: Progress) -> Search:
    """The search from a base fit. Raises DataError when an effect that was asked for cannot be added."""
    search = Search(solver, base, base)
    for name in options.add:
        search = _added_by_hand(search, name, options)
    for round_number in range(MOST_ROUNDS):
        if len({a.trial.effect for a in search.accepted}) >= MOST_EFFECTS:
            break
        share = round_number / MOST_ROUNDS
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
        best = _moved_on(search, best)
        search.accepted.append(Accepted(best, False, search.fit, others))
        search.solver = best.solver
        search.fit = final_polish(best.solver, best.fit)
        search = _weighed(search, solver, base)
    progress(1.0, "searched")
    return _only_a_cause(search, solver, base)


def _weighed(search: Search, solver: SteadyFit, base: Fit) -> Search:
    """The accepted effects by what each adds to the others, most first, without those that add nothing now.

    An effect that comes early may have stood in for one that came later, which then explains more alone.
    """
    if len(search.accepted) < 2:
        return search
    newest = search.accepted[-1].trial.effect
    worth: list[tuple[float, Accepted]] = []
    for a in search.accepted:
        kept = [b.trial.candidate for b in search.accepted if b is not a]
        try:
            rest = without(search.solver, search.fit, base.free, kept)
        except ExcitationError:  # nothing can be simulated without it
            worth.append((math.inf, a))
            continue
        trial = compared(search.solver, rest, search.fit, a.trial.candidate, search.own_error(besides=a))
        if trial.objection and not a.by_hand and a is not search.accepted[-1]:
            reason = f"with {newest} in the model, {trial.objection}"
            search.rejected[a.trial.effect] = Rejected(a.trial.effect, max(0.0, trial.share), reason)
        else:
            worth.append((rest.cost - search.fit.cost, a))
    by_worth = [a for _, a in sorted(worth, key=lambda item: (not item[1].by_hand, -item[0]))]
    if by_worth == search.accepted:
        return search
    as_before = [a for a in search.accepted if a in by_worth]
    try:
        again = rebuilt(search, by_worth, solver, base)
        if by_worth == as_before:
            return again
        other = search if as_before == search.accepted else rebuilt(search, as_before, solver, base)
    except ExcitationError:  # an order in which a simulation runs away is none
        return search
    first, sound = again.accepted[0].trial, not any(a.trial.objection and not a.by_hand for a in again.accepted)
    return again if sound and first.fit.cost < other.accepted[0].trial.fit.cost else other


def rebuilt(search: Search, order: Sequence[Accepted], solver: SteadyFit, base: Fit) -> Search:
    """The search as if its effects had been accepted in this order, each refit started from what is known by now."""
    again = Search(solver, base, base, rejected=search.rejected, untestable=search.untestable)
    for a in order:
        candidate = a.trial.candidate
        known = (*base.free, *(k for b in again.accepted for k in b.trial.candidate.keys), *candidate.keys)
        near = {k: v for k, v in search.fit.values.items() if k in known}
        far = {**again.fit.values, **{k: search.fit.values[k] for k in candidate.keys}}
        starts = [{**again.fit.values, **near}, far]
        trial = tried(again.solver, again.fit, candidate, starts, again.own_error())
        again.accepted.append(Accepted(trial, a.by_hand, again.fit, a.others))
        again.solver, again.fit = trial.solver, final_polish(trial.solver, trial.fit)
    return again


def _only_a_cause(search: Search, solver: SteadyFit, base: Fit) -> Search:
    """The search, or what it was before it, when all that was accepted leaves most of the gap: only resemblance.

    Unless what is left is no more than the method's own error, which nothing can close.
    """
    if not search.accepted or any(a.by_hand for a in search.accepted):
        return search
    *_, share = closed_share(search.solver, base, search.fit)
    left = remainder(search.solver, search.fit)
    if share >= MOST_OF_IT or not left.structured(left.gap):
        return search
    together = " and ".join(a.trial.effect for a in search.accepted)
    for a in search.accepted:
        reason = f"{together} would close {100 * share:.0f} % of the gap: what is missing resembles it, and is not it"
        search.rejected[a.trial.effect] = Rejected(a.trial.effect, max(0.0, a.trial.share), reason)
    return Search(solver, base, base, rejected=search.rejected, untestable=search.untestable)


def _part(progress: Progress, start: float, share: float, text: str) -> None:
    progress(start + share / MOST_ROUNDS, text)


def _candidates(search: Search, effects: tuple[str, ...], options: GapOptions) -> Iterator[Candidate]:
    problem, values = search.solver.problem, search.fit.values
    return candidates(problem, values, effects=effects, prismatic=options.prismatic)


def _scored(search: Search, options: GapOptions) -> list[Score]:
    tries = list(_candidates(search, options.effects, options))
    found = scores(search.solver, search.fit, tries)
    kept = []
    for score in found:
        name = score.candidate.effect
        if score.mark >= VISIBLE:
            kept.append(score)
            search.untestable.pop(name, None)
        elif all(s.candidate.effect != name for s in kept):
            effect = effect_named(name)
            search.untestable[name] = Untestable(name, score.orthogonal, effect.separated_by)
    promising = {s.candidate.effect for s in kept}
    for s in kept:
        if s.gain < WORTH_A_TRIAL and s.candidate.effect not in search.rejected:
            reason = "it would explain nothing of what is left"
            search.rejected[s.candidate.effect] = Rejected(s.candidate.effect, 0.0, reason, promising=False)
    for name in list(search.untestable):
        if name in promising:
            del search.untestable[name]
    return kept


def _trials(search: Search, found: list[Score], options: GapOptions, progress: Progress) -> list[Trial]:
    """Refits of the best few, best first: every promising candidate is sketched, the best sketches are finished."""
    loud = excess_of(search.solver, search.fit) > QUIET
    promising = [s for s in found if _promising(s, loud) and not (loud and _raced(s))]
    sketches: list[tuple[float, Score, Fit]] = []
    for i, score in enumerate(promising):
        progress(0.1 + 0.4 * i / len(promising), f"trying {_words(score)}")
        try:
            drawn = sketched(search.solver, search.fit, score)
        except ExcitationError:
            search.rejected.setdefault(score.candidate.effect, Rejected(score.candidate.effect, 0.0, RUNS_AWAY))
            continue
        sketches.append((drawn.cost, score, drawn))
    sketches.sort(key=lambda item: item[0])
    trials: list[Trial] = []
    own = search.own_error()
    for i, (cost, score, drawn) in enumerate(sketches):
        name = score.candidate.effect
        if i < MOST_TRIALS or (i < MOST_TRIALS_IN_VAIN and all(t.objection for t in trials)):
            progress(0.5 + 0.05 * i, f"refitting with {_words(score)}")
            try:
                trials.append(tried(search.solver, search.fit, score.candidate, [drawn.values], own))
            except ExcitationError:
                search.rejected.setdefault(name, Rejected(name, 0.0, RUNS_AWAY))
        else:
            search.rejected[name] = Rejected(name, 1.0 - cost / search.fit.cost, "other effects explain more")
    deep = next((s for s in found if _raced(s)), None) if loud else None
    if deep is not None:
        _search_deeply(search, deep, options, trials, own, progress)
    return sorted(trials, key=lambda t: -t.evidence)


def _moved_on(search: Search, best: Trial) -> Trial:
    """The trial that is to be accepted, where it leaves much of the gap moved on; unless that speaks against it."""
    if best.share > ENOUGH:
        return best
    try:
        deep = deepened(best, search.fit, search.own_error())
    except ExcitationError:
        return best
    return best if deep.objection else deep


def _search_deeply(
    search: Search, deep: Score, options: GapOptions, trials: list[Trial], own: float, progress: Progress
) -> None:
    """Add a refit that races from many shapes to the trials, unless it could not matter; else say why not.

    What is confused with it does not settle the matter.
    """
    name = deep.candidate.effect
    why = ""
    alike = effect_named(name).mistaken_for
    if any(t.share > ENOUGH and not t.objection and t.effect not in alike for t in trials):
        why = "other effects explain more"
    elif _nothing_left(search):
        why = "what is left is no more than noise and the method's own error"
    else:
        progress(0.9, f"trying {_words(deep)}")
        shapes = [c for c in _candidates(search, options.effects, options) if c.effect == name]
        starts = [{**search.fit.values, **c.probe.base, **c.start((1.0,))} for c in shapes if c.probe.raced]
        starts.append(best_start(search.solver, search.fit, deep))
        try:
            trials.append(tried(search.solver, search.fit, deep.candidate, starts, own))
        except ExcitationError:
            why = RUNS_AWAY
    if why:
        search.rejected[name] = Rejected(name, 0.0, why)


def _nothing_left(search: Search) -> bool:
    """Whether what was accepted leaves no more than noise and the method's own error: no case for a deep search."""
    if not search.accepted:
        return False
    left = remainder(search.solver, search.fit)
    return not left.structured(left.gap)


def _promising(score: Score, loud: bool) -> bool:
    """Whether a refit is worth its time. Where the gap is loud, the linear estimate may even have the wrong sign.

    And what the model mimics to first order shows along a curved valley only: damping looks like skewed encoders.
    """
    unsure = (score.candidate.probe.one_sided and score.gain == 0.0) or score.orthogonal < MIMICKED
    return score.gain >= WORTH_A_TRIAL or (loud and unsure)


def _raced(score: Score) -> bool:
    return effect_named(score.candidate.effect).raced


def _words(score: Score) -> str:
    return score.candidate.effect.replace("_", " ")


def _added_by_hand(search: Search, name: str, options: GapOptions) -> Search:
    """The search with an effect put in, whatever speaks against it. Raises DataError."""
    tries = list(_candidates(search, (name,), options))
    found = scores(search.solver, search.fit, tries)
    if not found:
        already = name in effects_in(search.fit.free)
        why = "is in the model already" if already else "makes no sense for this joint and these sensors"
        raise DataError(f"--add {name}: it {why}.")
    starts = starts_of(search.solver, search.fit, found[0])
    trial = tried(search.solver, search.fit, found[0].candidate, starts, search.own_error())
    search.accepted.append(Accepted(trial, True, search.fit, ()))
    search.solver, search.fit = trial.solver, final_polish(trial.solver, trial.fit)
    return search
