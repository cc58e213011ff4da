"""What an effect of many shapes changes, without simulating it: the link is linear for what is small.

Good enough to rank frequencies, of which there are many; the best is simulated.
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.filtering.spectral import Complexes
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.harmonics import periodic, periodic_slope
from flex_ident.simulation.terms import KINEMATIC_ERRORS, MOTOR_ENCODER_ERRORS, Term


def transmission_error_change(problem: FitProblem, values: Values, probe: Values) -> tuple[Floats, ...]:
    """Change (m,) of each residual when the small transmission error of `probe` joins the model.

    Equation 5 linearised about the motion, without the link's dry friction; the motor bears the spring's torque by
    virtual work.
    """
    terms = problem.terms(values)
    delay, skew = float(terms[Term.TORQUE_DELAY]), float(terms[Term.LINK_SKEW])
    stiffness, damping = float(terms[Term.STIFFNESS]), float(terms[Term.SPRING_DAMPING])
    inertia, viscous = float(terms[Term.LINK_INERTIA]), float(terms[Term.LINK_VISCOUS])
    small = problem.terms(probe)

    def link(omega: Floats) -> Complexes:
        spring = stiffness + 1j * omega * damping
        return np.asarray(spring / (spring - inertia * omega**2 + 1j * omega * viscous))

    def torque(omega: Floats) -> Complexes:
        late = np.exp(-1j * omega * delay)
        return np.asarray((stiffness + 1j * omega * damping) * (1.0 - link(omega)) * late)

    def position(omega: Floats) -> Complexes:
        return np.asarray(link(omega) * np.exp(-1j * omega * skew))

    error = periodic(small, KINEMATIC_ERRORS, problem.motion.position)
    slope = periodic_slope(small, KINEMATIC_ERRORS, problem.motion.position)
    moved = problem.link_response_of(values)
    assert moved is not None
    borne = problem.reduced(moved.spring_torque * slope, delay=delay)
    moved_torque, *moved_link = problem.reduced_through_each(error, torque, position)
    return (-moved_torque - borne, *(-link for link in moved_link))


def encoder_error_change(problem: FitProblem, values: Values, probe: Values) -> tuple[Floats, ...]:
    """Change (m,) of each residual when the small error of the motor's encoder in `probe` joins the model.

    Motor and link move by less than was recorded: their inertia, viscous friction and spring as `values` have them.
    """
    terms = problem.terms(values)
    delay, skew, lag = (float(terms[t]) for t in (Term.TORQUE_DELAY, Term.LINK_SKEW, Term.EFFORT_LAG))
    motor, friction = float(terms[Term.MOTOR_INERTIA]), float(terms[Term.MOTOR_VISCOUS])
    stiffness, damping = float(terms[Term.STIFFNESS]), float(terms[Term.SPRING_DAMPING])
    inertia, viscous = float(terms[Term.LINK_INERTIA]), float(terms[Term.LINK_VISCOUS])

    def link(omega: Floats) -> Complexes:
        spring = stiffness + 1j * omega * damping
        return np.asarray(spring / (spring - inertia * omega**2 + 1j * omega * viscous))

    def torque(omega: Floats) -> Complexes:
        felt = 1j * omega * friction - motor * omega**2
        if not problem.rigid:
            felt = felt + (stiffness + 1j * omega * damping) * (1.0 - link(omega))
        return np.asarray(felt * np.exp(-1j * omega * delay) / (1.0 + 1j * omega * lag))

    def position(omega: Floats) -> Complexes:
        return np.asarray(link(omega) * np.exp(-1j * omega * skew))

    error = periodic(problem.terms(probe), MOTOR_ENCODER_ERRORS, problem.motion.position)
    return tuple(problem.reduced_through_each(error, torque, position))


def second_mode_change(problem: FitProblem, values: Values, second: Floats) -> tuple[Floats, ...]:
    """Change (m,) of each residual when a part of the link, as heavy as before, swings behind a further spring.

    The part as the terms (len(Term),) of `second` say. To the rest of the link it is an inertia that depends on
    frequency. Linear: the link's dry friction damps as its first harmonic does.
    """
    terms = problem.terms(values)
    delay, skew = float(terms[Term.TORQUE_DELAY]), float(terms[Term.LINK_SKEW])
    stiffness, inertia, viscous = (float(terms[t]) for t in (Term.STIFFNESS, Term.LINK_INERTIA, Term.LINK_VISCOUS))
    part, spring, damping = (
        float(second[t]) for t in (Term.SECOND_INERTIA, Term.SECOND_STIFFNESS, Term.SECOND_DAMPING)
    )
    moved = problem.link_response_of(values)
    assert moved is not None
    speed = math.sqrt(2.0) * float(np.std(moved.velocity)) + 1e-12
    viscous += 4.0 * float(terms[Term.LINK_COULOMB]) / (math.pi * speed)

    def position(omega: Floats) -> Complexes:
        held = spring + 1j * omega * damping
        heavier = part * (held / (held - part * omega**2) - 1.0)
        return np.asarray(heavier * omega**2 / (stiffness - (inertia + heavier) * omega**2 + 1j * omega * viscous))

    changes = [stiffness * problem.reduced_through(moved.position, lambda w: position(w) * np.exp(-1j * w * delay))]
    if problem.link is not None:
        changes.append(-problem.reduced_through(moved.position, lambda w: position(w) * np.exp(-1j * w * skew)))
    return tuple(changes)


def mount_change(problem: FitProblem, values: Values, mount: Floats) -> tuple[Floats, ...]:
    """Change (m,) of each residual when the base on which the joint stands gives way.

    The base swings under the joint's reaction as the terms (len(Term),) of `mount` say; positions are relative to it.
    Linear: the link's dry friction damps as its first harmonic does.
    """
    terms = problem.terms(values)
    late = float(terms[Term.TORQUE_DELAY])
    own = float(terms[Term.MOTOR_INERTIA])
    reaction, dry = own * problem.motion.acceleration, 0.0
    moved = problem.link_response_of(values)
    if moved is not None:
        reaction = reaction + moved.spring_torque
        speed = math.sqrt(2.0) * float(np.std(moved.velocity)) + 1e-12
        dry = 4.0 * float(terms[Term.LINK_COULOMB]) / (math.pi * speed)
    base = tuple(float(mount[t]) for t in (Term.MOUNT_INERTIA, Term.MOUNT_STIFFNESS, Term.MOUNT_DAMPING))
    stiffness, link_inertia, viscous = (float(terms[t]) for t in (Term.STIFFNESS, Term.LINK_INERTIA, Term.LINK_VISCOUS))

    def deflection(omega: Floats) -> Complexes:
        if moved is None:
            return np.zeros(omega.size, complex)
        return np.asarray(link_inertia / (stiffness - link_inertia * omega**2 + 1j * omega * (viscous + dry)))

    def acceleration(omega: Floats) -> Complexes:
        alone = base[1] + 1j * omega * base[2] - (base[0] + own) * omega**2
        return np.asarray(omega**2 / (alone - omega**2 * stiffness * deflection(omega)))

    def torque(omega: Floats) -> Complexes:
        return np.asarray((own + stiffness * deflection(omega)) * acceleration(omega) * np.exp(-1j * omega * late))

    changes = [-problem.reduced_through(reaction, torque)]
    if problem.link is not None:
        changes.append(problem.reduced_through(reaction, lambda omega: deflection(omega) * acceleration(omega)))
    return tuple(changes)
