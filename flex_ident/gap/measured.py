"""A law as it was measured: over its variable, with its band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flex_ident.effects import effect_named
from flex_ident.effects.curve import TORQUE, Curve
from flex_ident.estimation.estimate import Estimate
from flex_ident.gap.thresholds import CURVE_BEND
from flex_ident.parameters.friction_curve import COVERED
from flex_ident.parameters.keys import by_effect, key_text
from flex_ident.recording import Floats
from flex_ident.simulation.curves import bend
from flex_ident.simulation.terms import BASE_TERMS, RIGID_TERMS

DRAWN = 60
"""Places between the ends of a curve, in each direction, at which it is given."""


@dataclass(frozen=True)
class MeasuredCurve:
    """A law over `variable`, in `unit`: `torque` (n,), N m, `at` places (n,), one standard deviation (n,) of each, and
    `covariance` (n, n) without what a curve may bend between its `points` (k,).

    `each_direction`: it is two curves, of the negative places and of the positive ones. `line`: the torque (n,) of the
    base model alone there. A part that the recording cannot tell from a constant, or from gravity, is in neither.
    """

    variable: str
    unit: str
    at: Floats
    torque: Floats
    std: Floats
    line: Floats
    points: Floats
    covariance: Floats
    each_direction: bool = False

    @property
    def lower(self) -> Floats:
        """Lower end of the 95 % band (n,), N m."""
        ends: Floats = self.torque - COVERED * self.std
        return ends

    @property
    def upper(self) -> Floats:
        """Upper end of the 95 % band (n,), N m."""
        ends: Floats = self.torque + COVERED * self.std
        return ends

    @property
    def sides(self) -> tuple[NDArray[np.bool_], ...]:
        """Which of the places, as masks (n,), make one curve each."""
        if not self.each_direction:
            return (np.ones(self.at.size, bool),)
        return tuple(side for side in (self.at < 0.0, self.at > 0.0) if side.any())


def measured_curve(estimate: Estimate, effect: str) -> MeasuredCurve | None:
    """The law of an effect that is a table in an estimate; None where it is none."""
    curve = effect_named(effect).curve
    if curve is None:
        return None
    values, rigid = estimate.fit.values, estimate.problem.rigid
    at, torque = curve.table_in(by_effect(values)[1][effect])
    where = _places(curve, at)
    bases = {term: (k, f) for k, (term, f) in (RIGID_TERMS if rigid else BASE_TERMS).items()}
    own = [bases[t] for t in curve.shown if t in bases and bases[t][0] in values]
    shapes = [(curve.held[t], bases[t][1]) for t in curve.shown if t in bases and bases[t][0] in values]
    keys = [
        *(key_text(effect, f"{TORQUE}_{n}") for n in curve.points_in(by_effect(values)[1][effect])),
        *(k for k, _ in own),
    ]
    size = np.array([values[k] for k in keys])

    def columns(places: Floats) -> Floats:
        tables = [curve.law(at, unit, places) for unit in np.eye(at.size)]
        return np.column_stack([*tables, *(f * shape(places) for shape, f in shapes)])

    others = [shape for term, shape in curve.held.items() if term not in curve.shown]
    law, base = columns(where), columns(where)
    base[:, : at.size] = 0.0
    if others:
        outside, there = (np.column_stack([shape(x) for shape in others]) for x in (where, at))
        taken = np.linalg.pinv(there, rcond=1e-3) @ columns(at)
        law = law - outside @ taken
    known = [i for i, k in enumerate(keys) if k in estimate.uncertainty.free]
    index = [estimate.uncertainty.free.index(keys[i]) for i in known]
    covariance = law[:, known] @ estimate.uncertainty.covariance[np.ix_(index, index)] @ law[:, known].T
    variance = np.maximum(np.diag(covariance), 0.0) + (CURVE_BEND * _bent(curve, at, torque, where)) ** 2
    return MeasuredCurve(
        curve.variable,
        curve.unit,
        where,
        law @ size,
        np.sqrt(variance),
        base @ size,
        at,
        covariance,
        curve.each_direction,
    )


def _places(curve: Curve, at: Floats) -> Floats:
    if not curve.each_direction:
        return np.linspace(at[0], at[-1], 2 * DRAWN)
    sides = [at[at < 0.0], at[at > 0.0]]
    return np.concatenate([np.linspace(s[0], s[-1], DRAWN) for s in sides if s.size > 1])


def _bent(curve: Curve, at: Floats, torque: Floats, where: Floats) -> Floats:
    """How far (n,) the table bends away from straight lines around each place."""
    sides = (at < 0.0, at > 0.0) if curve.each_direction else (np.ones(at.size, bool),)
    found = np.zeros(where.size)
    for side in sides:
        if not side.any():
            continue
        near = (where >= at[side][0]) & (where <= at[side][-1])
        found[near] = np.interp(where[near], at[side], bend(at[side], torque[side]))
    return found
