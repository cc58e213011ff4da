"""The parameters of an effect that is a table: where each point lies, and the torque there."""

from __future__ import annotations

from flex_ident.effects.curve import TORQUE, Curve
from flex_ident.effects.effect import EffectParameter
from flex_ident.simulation.terms import MOST_POINTS


def points(curve: Curve, where: str) -> tuple[EffectParameter, ...]:
    """Two parameters for each point that the table may have; `where` says in words what its points are over."""
    found = []
    for n, at, torque in zip(range(1, MOST_POINTS + 1), curve.table.at, curve.table.torque, strict=True):
        found += [
            EffectParameter(f"{curve.at}_{n}", curve.unit, f"{where} at point {n}", at, fixed=True),
            EffectParameter(f"{TORQUE}_{n}", "N m", f"torque there beyond the straight line, point {n}", torque),
        ]
    return tuple(found)
