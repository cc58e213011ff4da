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
from flex_ident.parameters.keys import key_text
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats

SAME = 1e-3
"""Singular value, over the largest, of shapes that are one and the same at all points."""
FINE = 4001
GRAVITY = 9.81
DRAWN = 60
"""Places between the ends of a curve, in each direction, at which it is given."""


@dataclass(frozen=True)
class MeasuredCurve:
    """A law over `variable`, in `unit`: `torque` (n,), N m, `at` places (n,), and one standard deviation (n,) of each.

    Its table has `points` (k,). `each_direction`: it is two curves, of the negative places and of the positive ones.
    `line`: the torque (n,) of the base model alone there. A part that the recording cannot tell from a constant, or
    from gravity, is in neither.
    """

    variable: str
    unit: str
    at: Floats
    torque: Floats
    std: Floats
    line: Floats
    points: Floats
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
    """The law of an effect that is a table in an estimate; None where it is none.

    Its band is that of the fit, wider by what is left over the noise; not of what else may be missing, which moves the
    parameters of the straight law.
    """
    curve = effect_named(effect).curve
    if curve is None:
        return None
    values, rigid = estimate.fit.values, estimate.problem.rigid
    own = values.effects[effect]
    at, torque = curve.table_in(own)
    where = _places(curve, at)
    shown = tuple(curve.shown_by(values, at, rigid=rigid))
    keys = [*(key_text(effect, f"{TORQUE}_{n}") for n in curve.points_in(own)), *shown]
    size = values.vector(keys)

    def columns(places: Floats) -> Floats:
        tables = [curve.law(at, unit, places) for unit in np.eye(at.size)]
        return np.column_stack([*tables, *curve.shown_by(shown, places, rigid=rigid).values()])

    law, there, line = columns(where), columns(at), columns(where)
    line[:, : at.size] = 0.0
    zero = _zero(curve, at, torque, values) if curve.anchored else 0.0
    if curve.anchored:
        law, there = law - columns(np.array([zero])), there - columns(np.array([zero]))
    taken = np.linalg.pinv(curve.centred(curve.left_out(at - zero)), rcond=SAME) @ curve.centred(there)
    law = law - curve.left_out(where - zero) @ taken
    free, left = estimate.plain.free, estimate.left
    known = [i for i, k in enumerate(keys) if k in free and k not in estimate.fit.at_bound]
    index = [free.index(keys[i]) for i in known]
    louder = max(1.0, left.gap / left.floor) if left.structured(left.gap) and left.floor > 0.0 else 1.0
    covariance = louder**2 * law[:, known] @ estimate.plain.covariance[np.ix_(index, index)] @ law[:, known].T
    bent = CURVE_BEND * curve.bent(at, torque, where)
    shifted = _zero_std(estimate) * np.gradient(law @ size, where) if curve.anchored else np.zeros_like(where)
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0) + bent**2 + shifted**2)
    return MeasuredCurve(
        curve.variable, curve.unit, where - zero, law @ size, std, line @ size, at - zero, curve.each_direction
    )


def _zero(curve: Curve, at: Floats, torque: Floats, values: Values) -> float:
    """Where the whole spring has no torque, rad: the encoders' zeros say nothing of it."""
    fine = np.linspace(at[0], at[-1], FINE)
    whole = values["K"] * fine + curve.law(at, torque, fine)
    return float(fine[int(np.argmin(np.abs(whole)))])


def _zero_std(estimate: Estimate) -> float:
    """Standard deviation of where the spring has no torque, rad: as far as the weight that it bears is open."""
    known, position = estimate.plain, float(np.mean(estimate.problem.motion.position))
    weights = {"MX": GRAVITY * np.cos(position), "MY": GRAVITY * np.sin(position)}
    keys = [k for k in weights if k in known.free and np.isfinite(known.std(k))]
    row, index = np.array([weights[k] for k in keys]), [known.free.index(k) for k in keys]
    return float(np.sqrt(row @ known.covariance[np.ix_(index, index)] @ row)) / estimate.fit.values["K"]


def _places(curve: Curve, at: Floats) -> Floats:
    if not curve.each_direction:
        return np.linspace(at[0], at[-1], 2 * DRAWN)
    sides = [at[at < 0.0], at[at > 0.0]]
    return np.concatenate([np.linspace(s[0], s[-1], DRAWN) for s in sides if s.size > 1])
