"""What the catalogue knows of one physical effect."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from flex_ident.recording import Floats

EXACT = 0.01
"""Law error of what is geometry, time or arithmetic rather than a model of a material."""
Where = Literal["motor", "spring", "link", "measurement"]


@dataclass(frozen=True)
class EffectParameter:
    """One number of an effect: its name, unit, the range that physics allows, and what a step of it looks like."""

    name: str
    unit: str
    meaning: str
    lower: float = float("-inf")
    upper: float = float("inf")


@dataclass(frozen=True)
class Effect:
    """A physical effect: its equation, what it adds to the simulation, and how to recognise it.

    `contribute(terms, parameters)` writes into the vector of `simulation.terms.Term` in place.
    `bin_by` names the variable against which its residual is to be looked at; `confused_with` the effects whose
    residual is alike, `separated_by` the experiment that tells them apart.
    """

    name: str
    summary: str
    equation: str
    parameters: tuple[EffectParameter, ...]
    contribute: Callable[[Floats, Mapping[str, float]], None]
    where: Where
    signature: str
    bin_by: str
    confused_with: tuple[str, ...] = ()
    separated_by: str = ""
    needs_spring: bool = False
    """Makes no sense for a rigid joint."""
    needs_link: bool = False
    """Can only be seen with a link encoder."""
    law_error: float = 0.05
    """Share of what it changes in the prediction that its law, ideal as it is, may get wrong."""
    imitable: float = 1.0
    """Share of the error of method and laws that could look like this effect."""

    def parameter(self, name: str) -> EffectParameter:
        """The parameter of that name; KeyError if there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)
