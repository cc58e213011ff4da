"""Effects that the recordings of a set found each by itself: which found which."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.effects import effect_named
from flex_ident.gap.explanation import Finding, GapExplanation
from flex_ident.parameters import Identification, Parameter
from flex_ident.parameters.keys import effect_in


@dataclass(frozen=True)
class Proposal:
    """An effect, on the motor's or on the link's side, with what each recording found of it: None where nothing."""

    effect: str
    side: str
    findings: tuple[Finding | None, ...]

    @property
    def of_recording(self) -> bool:
        """Whether another recording has another size of it."""
        return effect_named(self.effect).of_recording

    @property
    def finders(self) -> tuple[int, ...]:
        """The recordings that found it."""
        return tuple(i for i, own in enumerate(self.findings) if own is not None)

    @property
    def worth(self) -> tuple[int, float]:
        """In how many it was found, and the energy of the gap that it closed there."""
        known = [own for own in self.findings if own is not None]
        return len(known), sum(own.gap_before**2 - own.gap_after**2 for own in known)

    def own(self, result: Identification) -> list[Parameter]:
        """Its parameters in a recording's final model."""
        return [p for p in result.parameters if effect_in(p.key) == self.effect and side_of(p.key) == self.side]

    @property
    def times(self) -> int:
        """How often it is in the model: once, or as many harmonics as the recordings that found it have typically."""
        cycles = effect_named(self.effect).cycles
        if not cycles:
            return 1
        counts = [sum(p.key.startswith(cycles) for p in own.parameters) for own in self.findings if own is not None]
        return max(1, round(float(np.median(counts))))


def proposals(explanations: Sequence[GapExplanation]) -> list[Proposal]:
    """All effects that any of the recordings found, those found by most and closing most first."""
    found: dict[tuple[str, str], list[Finding | None]] = {}
    for i, explanation in enumerate(explanations):
        for finding in explanation.findings:
            side = "link" if any(side_of(p.key) for p in finding.parameters) else ""
            found.setdefault((finding.effect, side), [None] * len(explanations))[i] = finding
    every = [Proposal(effect, side, tuple(own)) for (effect, side), own in found.items()]
    return sorted(every, key=lambda p: p.worth, reverse=True)


def side_of(key: str) -> str:
    """`link` for a parameter of the variant on the link's side, else empty."""
    return "link" if key.endswith("_link") else ""
