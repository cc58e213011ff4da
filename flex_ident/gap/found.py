"""Where a search stands: the model's fit, the effects that were accepted, and those that were not."""

from __future__ import annotations

from dataclasses import dataclass, field

from flex_ident.gap.explanation import Rejected, Untestable
from flex_ident.gap.objections import own_error_of
from flex_ident.gap.thresholds import NEAR_TIE
from flex_ident.gap.trials import Trial
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.steady import SteadyFit


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
