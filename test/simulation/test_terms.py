"""Each term does what its declaration says: a Jacobian that a batch gets wrong is wrong without a word."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from flex_ident.effects import CATALOGUE, key_named
from flex_ident.likelihood.links import LinkResponses
from flex_ident.likelihood.problem import terms_of
from flex_ident.parameters import MEASUREMENT_UNITS, UNITS
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation import response
from flex_ident.simulation.batch import side_by_side
from flex_ident.simulation.compiled import COMPILED
from flex_ident.simulation.kernel import simulated_link
from flex_ident.simulation.motion import MotorMotion, motor_motion
from flex_ident.simulation.response import LinkMotion, link_motion, link_motions, motor_torque, stepped_link_motion
from flex_ident.simulation.terms import (
    ANGLE_CURVE,
    FRICTION_CURVE,
    HARMONICS,
    LINK_ENCODER_ERRORS,
    MOST_POINTS,
    MOTOR_ENCODER_ERRORS,
    SPRING_CURVE,
    Term,
)
from flex_ident.virtual_joint import COBOT_JOINT

RATE = 500.0
SIZES: dict[Term, float] = {
    Term.CUBIC_STIFFNESS: 4e8, Term.HALF_GAP: 3e-4, Term.HYSTERESIS_TORQUE: 2.0, Term.HYSTERESIS_DEFLECTION: 1e-3,
    Term.SPRING_DAMPING: 3.0, Term.LINK_VISCOUS_ASYMMETRY: 0.5, Term.LINK_VISCOUS_QUADRATIC: 1.0,
    Term.LINK_STRIBECK: 1.0, Term.LINK_STRIBECK_VELOCITY: 0.05, Term.LINK_LOAD_FRICTION: 0.05,
    Term.SECOND_INERTIA: 0.15, Term.SECOND_STIFFNESS: 3000.0, Term.SECOND_DAMPING: 0.5, Term.FRICTION_RATE: 0.05,
    Term.KINEMATIC_ERROR: 2e-4, Term.KINEMATIC_CYCLES: 80.0, Term.KINEMATIC_PHASE: 0.4,
    Term.INITIAL_DEFLECTION: 1e-4, Term.INITIAL_VELOCITY: 1e-3, Term.GRAVITY_COS: 20.0,
    Term.CABLE_STIFFNESS: 30.0, Term.CABLE_TORQUE: 5.0, Term.CABLE_COS_2: 4.0, Term.CABLE_SIN_2: 6.0,
    Term.FRICTION_WAVE: 1.0, Term.FRICTION_WAVE_CYCLES: 20.0, Term.FRICTION_WAVE_PHASE: 0.3,
    Term.OFFSET: 2.0, Term.MOTOR_VISCOUS_ASYMMETRY: 1.0, Term.MOTOR_VISCOUS_QUADRATIC: 1.0, Term.MOTOR_STRIBECK: 1.0,
    Term.MOTOR_STRIBECK_VELOCITY: 0.1, Term.MOTOR_LOAD_FRICTION: 0.05, Term.MOTOR_FRICTION_RATE: 0.05,
    Term.RIPPLE: 1.0, Term.RIPPLE_CYCLES: 60.0,
    Term.RIPPLE_PHASE: 0.3, Term.TORQUE_DELAY: 1e-3, Term.TORQUE_AVERAGING: 0.04, Term.LINK_SKEW: 1e-3,
    Term.LINK_SCALE: 1e-3, Term.LINK_DRIFT: 1e-4, Term.IRON_LOSS: 1e-6, Term.TORQUE_DROOP: 0.02,
    Term.GAIN_RATE: 0.01, Term.OFFSET_RATE: 0.2, Term.LINK_TURNOVER: 0.05, Term.STIFFNESS_COS_2: -900.0,
    Term.STIFFNESS_SIN_2: 500.0,
    Term.LINK_ZERO: 1e-2, Term.TORQUE_LIMIT: 30.0, Term.REVERSAL_SPEED: 0.02, Term.PRESLIDING: 1e-3,
    Term.BRISTLE_DEFLECTION: 5e-4, Term.BRISTLE_STRIBECK: 1.0, Term.BRISTLE_STRIBECK_VELOCITY: 0.05,
    Term.SOFT_FRICTION: 0.1, Term.SOFT_FRICTION_TIME: 0.01,
    Term.MOUNT_INERTIA: 30.0, Term.MOUNT_STIFFNESS: 4e5, Term.MOUNT_DAMPING: 100.0,
    Term.RELAXING_STIFFNESS: 1500.0, Term.RELAXATION_TIME: 0.02,
    Term.SOFT_ZONE_SHARE: 0.4, Term.SOFT_ZONE_DEFLECTION: 1e-3,
    Term.REVERSAL_LEAD: 2e-3, Term.EFFORT_LAG: 1e-3, Term.GRAVITY_REMOVED: 1.0,
    Term.FRICTION_REMOVED: 3.0, Term.FRICTION_REMOVED_SPEED: 0.05,
}  # fmt: skip
for _n in HARMONICS[1:]:
    for _one, _size in (("RIPPLE", 0.5), ("RIPPLE_CYCLES", 90.0), ("RIPPLE_PHASE", 0.7), ("KINEMATIC_ERROR", 1e-4),
                        ("KINEMATIC_CYCLES", 50.0), ("KINEMATIC_PHASE", 0.2), ("FRICTION_WAVE", 0.4),
                        ("FRICTION_WAVE_CYCLES", 30.0), ("FRICTION_WAVE_PHASE", 0.9)):  # fmt: skip
        SIZES[Term[f"{_one}{_n}"]] = _size
for _size, _cycles, _phase in (*MOTOR_ENCODER_ERRORS, *LINK_ENCODER_ERRORS):
    SIZES[_size], SIZES[_cycles], SIZES[_phase] = 1e-4, 70.0, 0.6
TABLES = {FRICTION_CURVE: 0.4, ANGLE_CURVE: 0.01, SPRING_CURVE: 1.5e-3}
"""Every law that is a table, and how far apart its points are."""
for _table, _apart in TABLES.items():
    SIZES[_table.points] = float(MOST_POINTS)
    for _i, (_at, _torque) in enumerate(zip(_table.at, _table.torque, strict=True)):
        SIZES[_at], SIZES[_torque] = _apart * (_i - 11.5), 2.0 + np.sin(2.0 * _i)
"""What each term may be in a cobot's joint; those of the base model are the joint's own."""
AS_THEY_ARE = {t for table in TABLES for t in (table.points, *table.at)}
"""Not varied: points keep their order."""


def motion() -> MotorMotion:
    """A sweep from standstill with a rest in the middle, so that the link sticks and reverses."""
    time = np.arange(0.0, 6.0, 1.0 / RATE)
    fade = np.clip(np.abs(time - 3.0) - 0.5, 0.0, 0.5) * 2.0
    return motor_motion(0.05 * fade * np.sin(2.0 * np.pi * time * (0.5 + time)), RATE, cutoff_hz=60.0, substeps=2)


def group(term: Term) -> tuple[Term, ...]:
    """The term, that which it shapes, and all that shape it: none of them acts without the others."""
    table = next((t for t in TABLES if term in (t.points, *t.at, *t.torque)), None)
    if table is not None:
        return (table.points, *table.at, *table.torque)
    whole = term.shape_of or term
    return tuple(t for t in Term if whole in (t, t.shape_of))


def with_term(term: Term, seed: int = 0) -> list[Floats]:
    """The cobot's terms with this one's group on, at random sizes, and the same with the term itself varied."""
    rng = np.random.default_rng([seed, int(term)])
    terms = terms_of(Values(COBOT_JOINT.parameters), rigid=False)
    for one in group(term):
        terms[one] = (terms[one] or SIZES[one]) * (1.0 if one in AS_THEY_ARE else rng.uniform(0.7, 1.3))
    many = [terms]
    for factor in rng.uniform(0.98, 1.02, 4):
        many.append(terms.copy())
        many[-1][term] *= factor
    return many


def same(one: LinkMotion, other: LinkMotion) -> bool:
    """Whether two motions of the link agree to rounding."""
    names = ("spring_torque", "position", "velocity")
    pairs = [(getattr(one, name), getattr(other, name)) for name in names]
    return all(float(np.max(np.abs(a - b))) < 1e-9 * float(np.max(np.abs(a))) for a, b in pairs)


@pytest.mark.slow
@pytest.mark.parametrize("term", list(Term), ids=lambda t: t.name)
def test_a_batch_is_what_single_simulations_are_for_every_term(term: Term) -> None:
    for seed in range(3):
        many = with_term(term, seed)
        for terms, together in zip(many, link_motions(many, motion()), strict=True):
            alone = stepped_link_motion(terms, motion())
            assert same(alone, together)
            assert same(alone, link_motion(terms, motion()))


def test_a_second_mass_may_be_less_than_nothing() -> None:
    """A mode above the band is fitted around none at all: the batch and single simulations go on there alike."""
    terms = terms_of(Values(COBOT_JOINT.parameters), rigid=False)
    plain = link_motion(terms, motion())
    terms[[Term.SECOND_INERTIA, Term.SECOND_STIFFNESS, Term.SECOND_DAMPING]] = -0.01, -1400.0, -0.15
    terms[Term.LINK_INERTIA] += 0.01
    alone = stepped_link_motion(terms, motion())
    assert all(same(alone, together) for together in link_motions([terms, terms], motion()))
    moved = float(np.max(np.abs(alone.position - plain.position)))
    assert 0.0 < moved < 1e-3


@pytest.mark.parametrize("term", [t for t in Term if t not in {c.points for c in TABLES}], ids=lambda t: t.name)
def test_a_term_moves_the_link_where_its_side_says_so(term: Term) -> None:
    first, *others = (link_motion(terms, motion()) for terms in with_term(term))
    moved = [float(np.max(np.abs(other.position - first.position))) for other in others]
    assert all(m > 0.0 for m in moved) if term.moves_link else not any(moved)


def values_with(name: str, seed: int) -> Values:
    """The cobot with the effect of that name, random sizes of every parameter it has."""
    rng = np.random.default_rng([seed, len(name)])
    own = {
        p.name: SIZES.get(p.term, 20.0) / p.factor * (1.0 if p.fixed else rng.uniform(0.7, 1.3))
        for p in CATALOGUE[name].parameters
    }
    return Values(COBOT_JOINT.parameters) | Values.of_effect(name, own)


@pytest.mark.parametrize("name", list(CATALOGUE))
def test_a_jacobian_is_what_single_simulations_give_for_every_effect(name: str) -> None:
    values = values_with(name, 1)
    ways = [values, *(values | {key: 1.001 * value} for key, value in values.items())]
    many = [terms_of(way, rigid=False) for way in ways]
    path = motion()
    links = LinkResponses(path, lambda position, _: position)
    sign = response.direction(path)
    for terms, together in zip(many, links.of_many(many), strict=True):
        alone = stepped_link_motion(terms, path)
        assert same(alone, together)
        torque = motor_torque(terms, path, alone, sign)
        np.testing.assert_allclose(motor_torque(terms, path, together, sign), torque, atol=1e-9 * np.max(torque))


def test_a_term_that_the_batch_does_not_know_is_simulated_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    made_up = len(Term)

    def with_drag(terms: Floats, base: Floats, base_rate: Floats, step: float, *filled: Floats) -> int:
        dragged = terms[:made_up].copy()
        dragged[Term.LINK_VISCOUS] += terms[made_up]
        return int(simulated_link(dragged, base, base_rate, step, *filled))

    monkeypatch.setattr(response, "simulated_link", with_drag)
    plain = np.append(terms_of(Values(COBOT_JOINT.parameters), rigid=False), 0.0)
    many = [plain.copy() for _ in range(6)]
    for drag, terms in enumerate(many[1:]):
        terms[made_up] = 2.0 + drag
    assert [side_by_side(terms) for terms in many] == [True] + 5 * [False]
    together = LinkResponses(motion(), lambda position, _: position).of_many(many)
    for terms, found in zip(many, together, strict=True):
        assert same(link_motion(terms, motion()), found)
    assert len({float(m.position[-1]) for m in together}) == len(many)


@pytest.mark.skipif(not COMPILED, reason="without numba all are simulated one by one")
def test_what_only_shapes_a_term_that_is_zero_does_not_leave_the_batch() -> None:
    terms = terms_of(Values({**COBOT_JOINT.parameters, "kinematic_error.cycles_per_turn": 80.0}), rigid=False)
    assert side_by_side(terms)
    terms[Term.KINEMATIC_ERROR] = 1e-4
    assert not side_by_side(terms)


def test_units_say_what_scales_with_force() -> None:
    effects: Mapping[str, str] = {f"{e.name}.{p.name}": p.unit for e in CATALOGUE.values() for p in e.parameters}
    for key, unit in {**UNITS, **effects, **MEASUREMENT_UNITS}.items():
        assert key_named(key).is_force == unit.startswith(("N", "kg")), key


def test_all_forces_together_leave_the_link_where_it_is() -> None:
    for term in (t for t in Term if t.moves_link and t.force):
        terms, *_ = with_term(term)
        scaled = np.array([3.0 * x if Term(i).force else x for i, x in enumerate(terms)])
        one, other = link_motion(terms, motion()), link_motion(scaled, motion())
        assert float(np.max(np.abs(one.position - other.position))) < 1e-9 * float(np.max(np.abs(one.position))), term
