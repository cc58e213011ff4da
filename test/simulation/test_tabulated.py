"""A law that is a table: a cubic through its points, the same wherever it is computed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from flex_ident.simulation.curves import curve, one_for_each_direction, point_slopes, tabulated
from flex_ident.simulation.terms import SPRING_CURVE, no_terms
from flex_ident.virtual_joint.plant import looked_up


@pytest.mark.parametrize("count", [2, 3, 4, 24])
def test_all_ways_to_compute_it_agree(count: int) -> None:
    rng = np.random.default_rng(count)
    at, torque = np.sort(rng.normal(size=count)), rng.normal(size=count)
    terms = no_terms()
    terms[SPRING_CURVE.points] = count
    terms[list(SPRING_CURVE.at[:count])], terms[list(SPRING_CURVE.torque[:count])] = at, torque
    where = np.linspace(at[0] - 1.0, at[-1] + 1.0, 500)
    found = curve(at, torque, where)
    outside = CubicHermiteSpline(at, torque, point_slopes(at, torque))(np.clip(where, at[0], at[-1]))
    np.testing.assert_allclose(found, outside, atol=1e-12)
    slopes, beyond = point_slopes(at, torque), where - np.clip(where, at[0], at[-1])
    straight = found + beyond * np.where(beyond < 0.0, slopes[0], slopes[-1])
    np.testing.assert_allclose([tabulated(terms, int(SPRING_CURVE.points), x) for x in where], straight, atol=1e-12)
    np.testing.assert_allclose([looked_up(np.column_stack((at, torque)), x) for x in where], found, atol=1e-12)


def test_parabolas_are_themselves_and_torques_add_up() -> None:
    at = np.array([-1.0, -0.2, 0.1, 0.8, 2.0])
    where = np.linspace(-1.0, 2.0, 200)
    np.testing.assert_allclose(curve(at, 3.0 - at + 2.0 * at**2, where), 3.0 - where + 2.0 * where**2, atol=1e-12)
    units = sum(k * curve(at, unit, where) for k, unit in enumerate(np.eye(5)))
    np.testing.assert_allclose(units, curve(at, np.arange(5.0), where), atol=1e-12)


def test_each_direction_has_a_curve_of_its_own() -> None:
    speed, torque = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([-4.0, -3.0, 1.0, 5.0])
    velocity, share = np.array([-1.5, -0.1, 0.1, 3.0, 0.5]), np.array([-1.0, -1.0, 1.0, 1.0, 0.5])
    found = one_for_each_direction(speed, torque, velocity, share)
    np.testing.assert_allclose(found, [-3.5, -3.0, 1.0, 5.0, 0.5])
