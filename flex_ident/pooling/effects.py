"""Which effects of a joint hold over several recordings: found in which, confirmed or contradicted by which others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Said = Literal["confirms", "contradicts", "cannot_tell", "not_tried"]
Outcome = Literal["accepted", "by_hand", "contradicted", "unconfirmed", "values_differ"]
STAYS: tuple[Outcome, ...] = ("accepted", "by_hand")
"""Outcomes with which an effect is in the joint's model."""


@dataclass(frozen=True)
class Heard:
    """What one recording says of an effect: whether its own explanation found it, and what the values that the other
    recordings found do to its gap, N m rms; NaN where no other found it (`not_tried`)."""

    found: bool
    said: Said = "not_tried"
    before: float = float("nan")
    after: float = float("nan")
    t: float = float("nan")


def outcome_of(heard: Sequence[Heard], *, of_recording: bool = False, by_hand: bool = False) -> Outcome:
    """Whether an effect is of the joint, by what each recording says of it.

    One that was found in one recording alone needs another that confirms it, and none that contradicts it; one that
    was found in several needs more that confirm the others' values than contradict them. Where none can tell, as the
    base imitates it, one that most found by themselves is accepted. What is `of_recording` has another size in each,
    and no other can speak of it. What was put in `by_hand` stays, whatever speaks against it.
    """
    if by_hand:
        return "by_hand"
    if of_recording:
        return "accepted"
    found = sum(own.found for own in heard)
    confirmed, contradicted = (sum(own.said == said for own in heard) for said in ("confirms", "contradicts"))
    if found > 1 and contradicted and contradicted >= confirmed:
        return "values_differ"
    if found == 1 and contradicted:
        return "contradicted"
    return "accepted" if confirmed or 2 * found > len(heard) > 2 else "unconfirmed"


def dissenters(heard: Sequence[Heard]) -> list[int]:
    """The recordings that contradict the effect as the others have it."""
    return [i for i, own in enumerate(heard) if own.said == "contradicts"]
