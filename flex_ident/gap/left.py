"""Why more is left than noise, or may be, once the search has ended."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from flex_ident.effects import CATALOGUE
from flex_ident.estimation.estimate import Estimate
from flex_ident.estimation.motion_told import ONE_OF_MANY
from flex_ident.gap.options import GapOptions
from flex_ident.likelihood.remainder import Remainder
from flex_ident.notices import Code, Notice, Reason, Why


@dataclass(frozen=True)
class Leftover:
    """What the final model leaves: `held` on data not fitted, whose gap is `after`, N m rms, and `whole` on all data.

    Where nothing is `named`, what is left on all data counts as well: what lies in two seconds may miss the blocks that
    were kept back.
    """

    estimate: Estimate
    held: Remainder
    after: float
    named: bool

    @property
    def whole(self) -> Remainder:
        """What is left on all data."""
        return self.estimate.left

    @property
    def structured(self) -> bool:
        """Whether more than noise and the method's own error is left."""
        return self.held.structured(self.after) or (not self.named and self.whole.structured(self.whole.gap))

    @property
    def floor(self) -> float:
        """The noise, N m rms: no more than what is left."""
        return min(self.held.floor, self.after)


def reasons_left(
    left: Leftover, options: GapOptions, told: Sequence[Notice], final: Sequence[Notice]
) -> Iterator[Reason]:
    """Each reason why not all is explained; `told` of the recording, and `final` of the final model."""
    estimate, whole, after = left.estimate, left.whole, left.after
    if left.structured:
        case = "tried" if options.effects else "catalogue"
        case = case if options.searching else "others"
        size = after if left.held.structured(after) else whole.gap
        yield Reason(Why.MORE_THAN_NOISE, numbers={"left": size, "noise": left.floor}, case=case)
    if estimate.coupling is not None and estimate.coupling.seen:
        joints = ", ".join(estimate.coupling.joints)
        yield Reason(Why.OTHER_JOINTS, joints, {"percent": 100.0 * estimate.coupling.share})
    if any(notice.code in ONE_OF_MANY for notice in told):
        yield Reason(Why.ONE_OF_MANY)
    if left.held.evidence == "none":
        yield Reason(Why.NOISE_UNTOLD, numbers={"left": after})
    if not left.named and whole.link is not None and whole.link.structured:
        yield Reason(Why.LINK_LEFT, numbers={"left": whole.link.gap, "noise": whole.link.floor})
    for n in final:
        if n.code == Code.CAUSE_SUSPECTED:
            scales = CATALOGUE[n.subject].scales_torque > 0.0
            yield Reason(
                Why.SCALE_SUSPECTED if scales else Why.CAUSE_SUSPECTED, n.subject, {"stds": n.numbers["moved_stds"]}
            )
    if estimate.strained:
        yield Reason(Why.CHAIN_AT_ITS_END, ", ".join(estimate.strained))
