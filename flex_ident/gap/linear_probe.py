"""What a small transmission error changes, without simulating it: the link is linear for what is small.

Its dry friction is left out: good enough to rank spatial frequencies, of which there are many; the best is simulated.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flex_ident.filtering.spectral import Complexes
from flex_ident.likelihood.problem import FitProblem, terms_of
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term


def transmission_error_change(
    problem: FitProblem, values: Mapping[str, float], probe: Mapping[str, float]
) -> tuple[Floats, ...]:
    """Change (m,) of each residual when the small transmission error in the flat keys of `probe` joins the model.

    Equation 5 linearised about the motion; the motor bears the spring's torque by virtual work.
    """
    terms = terms_of(values, rigid=problem.rigid)
    delay, skew = float(terms[Term.TORQUE_DELAY]), float(terms[Term.LINK_SKEW])
    stiffness, damping = float(terms[Term.STIFFNESS]), float(terms[Term.SPRING_DAMPING])
    inertia, viscous = float(terms[Term.LINK_INERTIA]), float(terms[Term.LINK_VISCOUS])
    small = terms_of(probe, rigid=problem.rigid)

    def link(omega: Floats) -> Complexes:
        spring = stiffness + 1j * omega * damping
        return np.asarray(spring / (spring - inertia * omega**2 + 1j * omega * viscous))

    def torque(omega: Floats) -> Complexes:
        late = np.exp(-1j * omega * delay)
        return np.asarray((stiffness + 1j * omega * damping) * (1.0 - link(omega)) * late)

    def position(omega: Floats) -> Complexes:
        return np.asarray(link(omega) * np.exp(-1j * omega * skew))

    amplitude, cycles = float(small[Term.KINEMATIC_ERROR]), float(small[Term.KINEMATIC_CYCLES])
    angle = cycles * problem.motion.position + float(small[Term.KINEMATIC_PHASE])
    error, slope = amplitude * np.sin(angle), amplitude * cycles * np.cos(angle)
    moved = problem.link_response_of(values)
    assert moved is not None
    borne = problem.reduced(moved.spring_torque * slope, delay=delay)
    changes = [-problem.reduced_through(error, torque) - borne]
    if problem.link is not None:
        changes.append(-problem.reduced_through(error, position))
    return tuple(changes)
