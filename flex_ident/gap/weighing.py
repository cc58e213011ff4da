"""Accepted effects against each other: what each adds to the others, and whether all together are causes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flex_ident.errors import ExcitationError
from flex_ident.gap.explanation import Rejected
from flex_ident.gap.found import Accepted, Search
from flex_ident.gap.objections import values_with
from flex_ident.gap.thresholds import MOST_OF_IT
from flex_ident.gap.trials import closed_share, compared, final_polish, tried, without
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.remainder import remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Reason, Why
from flex_ident.parameters.keys import effect_in


def weighed(search: Search, solver: SteadyFit, base: Fit) -> Search:
    """The accepted effects by what each adds to the others, most first, without those that add nothing now.

    An effect that comes early may have stood in for one that came later, which then explains more alone. And the newest
    may only have led the others out of a minimum of their own: then it goes, and they stay there.
    """
    if len(search.accepted) < 2:
        return search
    newest = search.accepted[-1]
    worth: list[tuple[float, Accepted]] = []
    why_not: Reason | None = None
    for a in search.accepted:
        kept = [b.trial.candidate for b in search.accepted if b is not a]
        try:
            rest = without(search.solver, search.fit, base.free, kept)
        except ExcitationError:  # nothing can be simulated without it
            worth.append((math.inf, a))
            continue
        trial = compared(search.solver, rest, search.fit, a.trial.candidate, search.own_error(besides=a))
        if trial.objection is not None and not a.by_hand and a is not newest:
            reason = Reason(Why.BESIDE_ANOTHER, newest.trial.effect, because=trial.objection)
            search.rejected[a.trial.effect] = Rejected(a.trial.effect, max(0.0, trial.share), reason)
        else:
            why_not = trial.objection if a is newest and not a.by_hand else why_not
            worth.append((rest.cost - search.fit.cost, a))
    if why_not is not None and len(worth) == len(search.accepted):
        worth = [(cost, a) for cost, a in worth if a is not newest]
        reason = Reason(Why.ALREADY_EXPLAINED, because=why_not)
        if all(a.trial.effect != newest.trial.effect for _, a in worth):  # else one harmonic stays, the next is none
            search.rejected[newest.trial.effect] = Rejected(newest.trial.effect, max(0.0, newest.trial.share), reason)
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
        near = values_with(search.fit.values, known).without([k for k in search.fit.values.base if k not in known])
        far = again.fit.values | near.only([k for k in near if effect_in(k) == candidate.effect])
        starts = [again.fit.values | near, far]
        trial = tried(again.solver, again.fit, candidate, starts, again.own_error())
        again.accepted.append(Accepted(trial, a.by_hand, again.fit, a.others))
        again.solver, again.fit = trial.solver, final_polish(trial.solver, trial.fit)
    return again


def only_a_cause(search: Search, solver: SteadyFit, base: Fit) -> Search:
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
        reason = Reason(Why.RESEMBLES, together, {"percent": 100.0 * share})
        search.rejected[a.trial.effect] = Rejected(a.trial.effect, max(0.0, a.trial.share), reason)
    return Search(solver, base, base, rejected=search.rejected, untestable=search.untestable)
