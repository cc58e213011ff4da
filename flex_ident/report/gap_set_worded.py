"""What several recordings say of one effect, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flex_ident.effects import effect_named
from flex_ident.gap.shared import Proposal
from flex_ident.notices import Code, Notice
from flex_ident.pooling.effects import Heard, Outcome, dissenters
from flex_ident.report.sentences import sentence


def evidence_text(proposal: Proposal, heard: Sequence[Heard], names: Sequence[str]) -> str:
    """Why an effect was accepted: in which recordings it was found, and what its values do to those left out."""
    by_hand = any(own is not None and own.verdict == "by_hand" for own in proposal.findings)
    found = "put in by hand" if by_hand else f"found in {len(proposal.finders)} of {len(names)} recordings"
    text = f"{effect_named(proposal.effect).summary}: {found}"
    if proposal.of_recording:
        return f"{text}; each recording has its own, and no other can speak of it."
    tried = [own for own in heard if own.said != "not_tried"]
    confirmed = [own for own in tried if own.said == "confirms"]
    if not confirmed:
        return f"{text}; with the values of the others no gap tells: the base model imitates it there."
    before, after = (float(np.sqrt(np.mean(np.square(x)))) for x in
                     ([own.before for own in confirmed], [own.after for own in confirmed]))  # fmt: skip
    text += (
        f"; with the values of the others the gap of a recording left out falls in {len(confirmed)} of {len(tried)}, "
        f"there from {before:.3g} to {after:.3g} N m"
    )
    against = [names[i] for i in dissenters(heard)]
    return f"{text}; {', '.join(against)} contradict{'s' if len(against) == 1 else ''} it." if against else f"{text}."


def reason_text(proposal: Proposal, heard: Sequence[Heard], outcome: Outcome, names: Sequence[str]) -> str:
    """Why an effect was not accepted."""
    texts = {
        "case": outcome, "effect": proposal.effect, "found": ", ".join(names[i] for i in proposal.finders),
        "against": ", ".join(names[i] for i in dissenters(heard)),
    }  # fmt: skip
    return sentence(Notice(Code.EFFECT_NOT_SHARED, proposal.effect, texts=texts))
