"""The search: one missing effect at a time, until what is left is noise or nothing in the catalogue explains it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial

from flex_ident.effects import effect_named
from flex_ident.errors import DataError, ExcitationError
from flex_ident.gap.curves import curve_candidates, curved
from flex_ident.gap.explanation import Rejected, Untestable
from flex_ident.gap.found import Accepted, Search
from flex_ident.gap.options import GapOptions
from flex_ident.gap.thresholds import CLOSES_ALL, ENOUGH, MIMICKED, QUIET, WORTH_A_TRIAL
from flex_ident.gap.trials import (
    Trial,
    deepened,
    excess_of,
    final_polish,
    tried,
    unstuck,
)
from flex_ident.gap.weighing import only_a_cause, weighed
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.remainder import Remainder, remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.likelihood.thresholds import STRUCTURE
from flex_ident.notices import Reason, Why
from flex_ident.parameters.values import Values
from flex_ident.screening.candidates import Candidate, candidates
from flex_ident.screening.scoring import Score, scores
from flex_ident.screening.sketching import effects_in, raced_starts, sketched, starts_of
from flex_ident.screening.thresholds import VISIBLE

Progress = Callable[[float, str], None]
MOST_EFFECTS, MOST_ROUNDS = 4, 8
"""Different effects that are accepted at most, and rounds: a harmonic each."""
MOST_TRIALS, MOST_TRIALS_IN_VAIN = 4, 8
"""Sketches that are finished, and how many while something speaks against each."""


NOTHING_LEFT, RUNS_AWAY = Reason(Why.NOTHING_LEFT), Reason(Why.RUNS_AWAY)
OTHERS = Reason(Why.OTHERS_EXPLAIN_MORE)


def searched(
    solver: SteadyFit, base: Fit, options: GapOptions, progress: Progress, *, sure: Collection[str] = ()
) -> Search:
    """The search from a base fit. Raises DataError when an effect that was asked for cannot be added.

    `sure`: effects that the base left something out for. They are sought although no more than noise is left.
    """
    search = Search(solver, base, base)
    for name in options.add:
        search = _added_by_hand(search, name, options)
    led_on: set[str] = set()
    for round_number in range(MOST_ROUNDS if options.searching else 0):
        if len({a.trial.effect for a in search.accepted}) >= MOST_EFFECTS:
            break
        share = round_number / MOST_ROUNDS
        progress(share, "screening")
        found = _scored(search, options)
        left = remainder(search.solver, search.fit)
        if _is_noise(left):
            _leave(search, [s for s in found if s.candidate.effect not in sure])
            found = [s for s in found if s.candidate.effect in sure]
        if not found:
            break
        trials = _trials(search, found, options, partial(_part, progress, share))
        if _is_nothing(left):
            trials = [_doubted(t) for t in trials]
        best = _best(trials, sure)
        for t in trials:
            if t is not best and t.objection is not None:
                search.rejected[t.effect] = Rejected(t.effect, max(0.0, t.share), t.objection)
        if best is None:
            break
        search.rejected.pop(best.effect, None)
        others = tuple(t for t in trials if t is not best)
        best = _moved_on(search, best)
        search.accepted.append(Accepted(best, False, search.fit, others))
        search.solver = best.solver
        search.fit = unstuck(best.solver, final_polish(best.solver, best.fit))
        search = weighed(search, solver, base)
        if all(a.trial.candidate is not best.candidate for a in search.accepted):  # it only led the others on
            if best.effect in led_on:
                break
            led_on.add(best.effect)
    progress(1.0, "measuring curves")
    if not _is_nothing(remainder(search.solver, search.fit)):
        search = curved(search, solver, base, options)
    return only_a_cause(search, solver, base)


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
            reason = Reason(Why.EXPLAINS_NOTHING)
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
            search.rejected[name] = Rejected(name, 1.0 - cost / search.fit.cost, OTHERS)
    deep = next((s for s in found if _raced(s)), None) if loud else None
    if deep is not None:
        _search_deeply(search, deep, options, trials, own, progress)
    return sorted(trials, key=lambda t: -t.evidence)


def _best(trials: Sequence[Trial], sure: Collection[str]) -> Trial | None:
    """The first trial that nothing speaks against, or one of a `sure` effect that closes nearly as much: identification
    fits it, and what imitates it with more numbers than it has comes second."""
    sound = [t for t in trials if not t.objection]
    if not sound:
        return None
    return next((t for t in sound if t.effect in sure and t.share > ENOUGH * sound[0].share), sound[0])


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
    why: Reason | None = None
    alike = effect_named(name).mistaken_for
    if any(t.share > ENOUGH and not t.objection and t.effect not in alike for t in trials):
        why = OTHERS
    else:
        progress(0.9, f"trying {_words(deep)}")
        shapes = _candidates(search, options.effects, options)
        starts = raced_starts(search.solver, search.fit, deep, shapes)
        try:
            trials.append(tried(search.solver, search.fit, deep.candidate, starts, own))
        except ExcitationError:
            why = RUNS_AWAY
    if why is not None:
        search.rejected[name] = Rejected(name, 0.0, why)


def _is_noise(left: Remainder) -> bool:
    """Whether no more is left than noise, of the torque, and of the link's position than noise and the method's own
    error: whatever a candidate explained of that, nothing would be missing without it."""
    return left.gap <= STRUCTURE * left.floor and not (left.link is not None and left.link.structured)


def _is_nothing(left: Remainder) -> bool:
    """Whether no more is left than noise and the method's own error."""
    return not left.structured(left.gap) and not (left.link is not None and left.link.structured)


def _doubted(trial: Trial) -> Trial:
    """A trial on what may be the method's own error: what is true closes that whole, what only resembles it a part."""
    if trial.objection or trial.share >= CLOSES_ALL:
        return trial
    return replace(trial, objection=Reason(Why.PART_OF_OWN_ERROR, numbers={"percent": 100.0 * trial.share}))


def _leave(search: Search, found: Sequence[Score]) -> None:
    """Say of what promised to explain something why it is not tried."""
    for score in found:
        if score.gain >= WORTH_A_TRIAL:
            name = score.candidate.effect
            search.rejected[name] = Rejected(name, 0.0, NOTHING_LEFT)


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
    curves = list(curve_candidates(effect_named(name), search.solver.problem, search.fit.values))
    if curves and name not in effects_in(search.fit.free):
        return _with_trial(search, curves[-1], [search.fit.values | curves[-1].start((1.0,))])
    tries = list(_candidates(search, (name,), options))
    found = scores(search.solver, search.fit, tries)
    if not found:
        already = name in effects_in(search.fit.free)
        why = "is in the model already" if already else "makes no sense for this joint and these sensors"
        raise DataError(f"--add {name}: it {why}.")
    return _with_trial(search, found[0].candidate, starts_of(search.solver, search.fit, found[0]))


def _with_trial(search: Search, candidate: Candidate, starts: Sequence[Values]) -> Search:
    trial = tried(search.solver, search.fit, candidate, starts, search.own_error())
    search.accepted.append(Accepted(trial, True, search.fit, ()))
    search.solver, search.fit = trial.solver, final_polish(trial.solver, trial.fit)
    return search
