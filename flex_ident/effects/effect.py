"""What the catalogue knows of one physical effect."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flex_ident.effects.curve import Curve
from flex_ident.effects.probe import Probe, Scales
from flex_ident.effects.starting import Scans, Start
from flex_ident.notices import Reason
from flex_ident.parameters.prior import Prior
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

EXACT = 0.01
"""Law error of what is geometry, time or arithmetic rather than a model of a material."""
FINE: tuple[float, ...] = tuple(map(float, np.linspace(-0.06, 0.06, 13)))
COARSE: tuple[float, ...] = tuple(map(float, np.linspace(-0.3, 0.3, 5)))
"""Relative steps to the neighbours of the best probe of a grid."""
BEYOND_THE_LAW = 4.0
"""A loss that grows with speed squared up to 1 rad/s and no further moved K by four times what the law without an end
says (two recordings of an adversary)."""
Where = Literal["motor", "spring", "link", "measurement"]


@dataclass(frozen=True)
class EffectParameter:
    """One number of an effect: what it is, the range that physics allows, and the term it adds to, times `factor`."""

    name: str
    unit: str
    meaning: str
    term: Term
    factor: float = 1.0
    lower: float = float("-inf")
    upper: float = float("inf")
    angle: bool = False
    """An angle: it has no size, and no limit that would mean anything."""
    fixed: bool = False
    """Given and never fitted: where a point of a curve lies."""

    @property
    def on_link(self) -> bool:
        """Whether it belongs to the variant of its effect on the link's side, alone."""
        return self.name.endswith("_link")


@dataclass(frozen=True)
class Effect:
    """A physical effect: its equation, what it adds to the simulation, and how to recognise it.

    `parameters` say to which terms of the simulation it adds: its law. `probes(scales)` gives the sizes and shapes at
    which it enters the regression on what a model leaves.
    `bin_by` names the variable against which its residual is to be looked at; `confused_with` the effects whose
    residual is alike, `separated_by` the experiment that tells them apart.
    """

    name: str
    summary: str
    equation: str
    parameters: tuple[EffectParameter, ...]
    probes: Callable[[Scales], Iterator[Probe]]
    where: Where
    signature: str
    bin_by: str
    confused_with: tuple[str, ...] = ()
    separated_by: str = ""
    mistaken_for: tuple[str, ...] = ()
    """Those of them that may close all of the gap where it is this."""
    refined: tuple[str, tuple[float, ...]] = ("", ())
    """The parameter whose grid is refined around the best probe, and the relative steps of that."""
    raced: bool = False
    """Its refit races from several shapes: it has many minima."""
    replaces: str = ""
    """Measurement key, confined to one sample, that the effect takes over from."""
    stand_ins: tuple[str, ...] = ()
    """Nuisances that stand for the effect where it lies out of sight, and go when it is in the model."""
    shown_by: tuple[str, ...] = ()
    """Those that are nothing where the effect is not there: where one is certain, the search goes without it."""
    of_recording: bool = False
    """Belongs to a recording and not to the joint: another recording of the same joint has another size of it."""
    needs_spring: bool = False
    """Makes no sense for a rigid joint."""
    needs_link: bool = False
    """Can only be seen with a link encoder."""
    scales_torque: float = 0.0
    """It changes the torque of the whole model by a share: inertias and stiffness follow it, and hardly a gap is left.
    The factor by which they may follow it further than its law says; 0 for an effect that does nothing of the kind."""
    forces_open: Callable[[Mapping[str, float], float], float] | None = None
    """Relative standard deviation of all forces where it is in the model, from its parameters and the recording's
    duration, s: its law says less of what scales them than it seems."""
    law_error: float = 0.05
    """Share of what it changes in the prediction that its law, ideal as it is, may get wrong."""
    essential: tuple[str, ...] = ()
    """Parameters without which it is another effect: each must be known to be there, where it is in the law at all."""
    at_reversals: bool = False
    """Whether it acts where friction turns over, so that the method's own error there may pass for it."""
    imitable: float = 1.0
    """Share of the error of method and laws that could look like this effect."""
    cycles: str = ""
    """Name of the parameter that says how many periods it has in a turn of the motor; empty for what has none."""
    whole_periods: bool = True
    """A part of a period within the range of motion is something else, gravity or a spring."""
    again: tuple[str, ...] = ("",)
    """Suffixes of its parameters, one for each time that it may be in the model: a harmonic each. Probes have none."""
    start: Callable[[Scans], Start | None] | None = None
    """Where a fit may start that the fit without the effect is too far off for; None where there is nothing better."""
    priors: Callable[[Floats], Mapping[str, Prior]] | None = None
    """What is known of its parameters before the fit, from the magnitude of the recorded torque (n,), N m."""
    unseen: Callable[[Values], tuple[Probe, ...]] | None = None
    """What of it may be in any joint, from the model's own values: alternatives that are not in the model, of one
    column at one standard deviation each. The intervals hold it as far as the recording does not rule it out."""
    reach: Callable[[Mapping[str, float], Values], Reason | None] | None = None
    """Why its parameters are larger than they can be beside the model's values; None where they are not."""
    of_noise: Callable[[Mapping[str, float], Floats, float], Reason | None] | None = None
    """Why what it takes off the recorded torque (n,), N m, with white noise of that standard deviation, N m, may be the
    noise alone; None where it is more."""
    curve: Curve | None = None
    """The effect is no law but a table that is measured: for what no law of the catalogue closes."""
    trades_with: tuple[str, ...] = ()
    """Base keys that stand in for it but for little."""
    trade_error: float = 0.0
    """Share of its first parameter by which this and they may be wrong for it, one standard deviation."""

    def parameter(self, name: str) -> EffectParameter:
        """The parameter of that name; KeyError if there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)

    def contribute(self, terms: Floats, values: Mapping[str, float]) -> None:
        """Add its parameters, those in `values`, to the vector of terms (len(Term),) in place."""
        for parameter in self.parameters:
            terms[parameter.term] += parameter.factor * values.get(parameter.name, 0.0)
        if self.curve is not None:
            terms[self.curve.table.points] += len(self.curve.points_in(values))
