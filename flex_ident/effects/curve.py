"""A law as a table: torque at points of a variable, under numbered parameters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np

from flex_ident.parameters.prior import Prior
from flex_ident.recording import Floats
from flex_ident.simulation.curves import bend, curve, one_for_each_direction
from flex_ident.simulation.terms import BASE_TERMS, MOST_POINTS, RIGID_TERMS, Table, Term

SPREAD = 0.3
"""Torque at a point, one standard deviation, over the rms of the recorded torque: what is no larger than this is
hardly held back, and what no data reach stays at nothing."""
TORQUE = "torque"


def line(at: Floats) -> Floats:
    """A straight line through zero, (k,)."""
    return at


def level(at: Floats) -> Floats:
    """The same everywhere, (k,)."""
    return np.ones_like(at)


@dataclass(frozen=True)
class Curve:
    """What a table is over, and what else in a model does a part of it.

    `variable` names what it is over, as `gap.where` does, `at` the parameters that say where its points lie, `unit`
    theirs. `held` are terms of the base model, each with the shape (k,) of its torque over points (k,): the curve is
    what is left of the law without them, in the mean over its points. `contains` are effects whose laws it can be.
    """

    variable: str
    at: str
    unit: str
    table: Table
    held: Mapping[Term, Callable[[Floats], Floats]]
    contains: tuple[str, ...] = ()
    shown: tuple[Term, ...] = ()
    """Those of `held` that belong to the law as it is drawn and read; what the others can do is taken out of it."""
    anchored: bool = False
    """No torque is where the variable is zero: as drawn, the variable is counted from where the law has none."""
    sought: bool = True
    """The search tries it unasked."""
    each_direction: bool = False
    """Two curves, one for each direction of motion: they meet nowhere."""

    def held_by(self, keys: Collection[str], at: Floats, *, rigid: bool) -> dict[str, Floats]:
        """Those of the keys that are base keys and do a part of the curve: the torque (k,) of each over points (k,).

        What acts on the link does so at another angle than the motor's, unless the joint is rigid.
        """
        terms = (RIGID_TERMS if rigid else BASE_TERMS).items()
        here = [(k, term, factor) for k, (term, factor) in terms if k in keys and term in self.held]
        return {k: f * self.held[term](at) for k, term, f in here if rigid or term.side == self.table.points.side}

    def centred(self, torques: Floats) -> Floats:
        """Torques (k,) or columns of them (k, c) as compared: less their means where a curve may be shifted."""
        return torques - torques.mean(axis=0) if self.anchored else torques

    def shown_by(self, keys: Collection[str], at: Floats, *, rigid: bool) -> dict[str, Floats]:
        """Those of the base keys that belong to the law as it is drawn: the torque (k,) of each for a value of one."""
        terms = (RIGID_TERMS if rigid else BASE_TERMS).items()
        return {k: f * self.held[term](at) for k, (term, f) in terms if k in keys and term in self.shown}

    def left_out(self, at: Floats) -> Floats:
        """Shapes (k, c) over points (k,) of what is taken out of the law as it is drawn."""
        return np.column_stack([np.zeros((at.size, 0)), *(h(at) for t, h in self.held.items() if t not in self.shown)])

    def bent(self, at: Floats, torque: Floats, where: Floats) -> Floats:
        """How far (n,) the table bends away from straight lines around each place (n,)."""
        sides = (at < 0.0, at > 0.0) if self.each_direction else (np.ones(at.size, bool),)
        found = np.zeros(where.size)
        for side in (side for side in sides if side.any()):
            near = (where >= at[side][0]) & (where <= at[side][-1])
            found[near] = np.interp(where[near], at[side], bend(at[side], torque[side]))
        return found

    def law(self, at: Floats, torque: Floats, where: Floats) -> Floats:
        """The torque (n,) of the table (k,) at `where` (n,), N m."""
        if self.each_direction:
            return one_for_each_direction(at, torque, where, np.sign(where))
        return curve(at, torque, where)

    def points_in(self, values: Mapping[str, float]) -> tuple[int, ...]:
        """Numbers of the points among the effect's own parameters."""
        return tuple(n for n in range(1, MOST_POINTS + 1) if f"{TORQUE}_{n}" in values)

    def table_in(self, values: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Where the points lie (k,), and the torque at each (k,), of the effect's own parameters."""
        numbers = self.points_in(values)
        at, torque = ([values.get(f"{what}_{n}", 0.0) for n in numbers] for what in (self.at, TORQUE))
        return np.array(at), np.array(torque)

    def parameters_of(self, at: Floats, torque: Floats) -> dict[str, float]:
        """The effect's own parameters for points (k,) and torques (k,)."""
        found = {f"{self.at}_{n + 1}": float(x) for n, x in enumerate(at)}
        return {**found, **{f"{TORQUE}_{n + 1}": float(y) for n, y in enumerate(torque)}}

    def priors(self, recorded_torque: Floats) -> dict[str, Prior]:
        """What is known of the torque at each point beforehand: no more than a share of what is recorded (n,), N m."""
        spread = SPREAD * float(np.sqrt(np.mean(recorded_torque**2))) or 1.0
        prior = Prior(0.0, spread, -np.inf, np.inf)
        return {f"{TORQUE}_{n}": prior for n in range(1, MOST_POINTS + 1)}

    def complaint(self, values: Mapping[str, float]) -> str:
        """Why the effect's own parameters are no table; empty where they are one."""
        numbers, places = self.points_in(values), [n for n in range(1, MOST_POINTS + 1) if f"{self.at}_{n}" in values]
        if len(numbers) < 2 or numbers != tuple(range(1, len(numbers) + 1)) or list(numbers) != places:
            return f"needs as many values of {self.at} as of {TORQUE}, 2 to {MOST_POINTS}"
        at, _ = self.table_in(values)
        if not (np.diff(at) > 0.0).all():
            return f"needs values of {self.at} that increase"
        return "has a point at no speed, which is of neither direction" if self.each_direction and 0.0 in at else ""
