"""A drive that gives way is a law between the torque delivered and the one recorded, and works both ways."""

import numpy as np

from flex_ident.simulation.drive import delivered_torque, recorded_torque
from flex_ident.simulation.terms import Term, no_terms

RECORDED = np.linspace(-50.0, 50.0, 101)
VELOCITY = np.linspace(2.0, -2.0, 101)


def test_what_is_recorded_of_a_saturating_torque_is_its_inverse() -> None:
    terms = no_terms()
    terms[Term.IRON_LOSS] = 1e-4
    delivered = RECORDED / (1.0 + 1e-4 * RECORDED**2)
    assert np.allclose(recorded_torque(terms, delivered, VELOCITY), RECORDED, rtol=1e-12)


def test_what_is_recorded_of_a_drooping_torque_is_its_inverse() -> None:
    terms = no_terms()
    terms[Term.TORQUE_DROOP] = 0.05
    delivered = RECORDED / (1.0 + 0.05 * VELOCITY**2)
    assert np.allclose(recorded_torque(terms, delivered, VELOCITY), RECORDED, rtol=1e-12)


def test_a_torque_beyond_what_the_saturation_gives_is_read_as_a_finite_one() -> None:
    terms = no_terms()
    terms[Term.IRON_LOSS] = 1e-3  # at most 15.8 N m
    assert np.isfinite(recorded_torque(terms, RECORDED, VELOCITY)).all()


def test_without_losses_nothing_is_changed() -> None:
    terms = no_terms()
    assert recorded_torque(terms, RECORDED, VELOCITY) is RECORDED
    assert delivered_torque(terms, RECORDED) is RECORDED
    terms[Term.TORQUE_LIMIT] = 20.0
    assert float(np.max(delivered_torque(terms, RECORDED))) == 20.0
