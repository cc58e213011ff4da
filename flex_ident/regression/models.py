"""The linear models: eq. 13 (both positions), eqs. 18 to 20 (motor only), and the rigid joint.

Each function writes the regression out, column by column, and returns matrix (n, p), target (n,) and names before
filtering; the caller reduces both alike.
"""

from __future__ import annotations

import numpy as np

from flex_ident.recording import Floats, Recording
from flex_ident.regression.observation import GRAVITY, Observation

Equations = tuple[Floats, Floats, tuple[str, ...]]


def both_positions(recording: Recording, at: Observation, *, measurement: bool) -> tuple[Equations, Equations]:
    """The two halves of eq. 13: the motor's equation (eq. 6) and the link's (eq. 5, whose left side is zero).

        Gamma_m = Jm qm'' + FVm qm' + FSm sign(qm') + K (qm - q)
        0       = JL q''  + FV q'   + FS sign(q')   + MX g cos q + MY g sin q - K (qm - q)

    With `measurement` the columns of the measurement chain follow: a constant torque, the torque's delay, the link
    encoder's zero (times K) and its skew (times K).
    """
    assert recording.link_position is not None
    qm, q = at.derivative(recording.motor_position, 0), at.derivative(recording.link_position, 0)
    vm, v = at.derivative(recording.motor_position, 1), at.derivative(recording.link_position, 1)
    am, a = at.derivative(recording.motor_position, 2), at.derivative(recording.link_position, 2)
    zero, one = np.zeros_like(qm), np.ones_like(qm)
    names = ["Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "MX", "MY"]
    motor = [am, qm - q, zero, vm, at.sign(vm, am), zero, zero, zero, zero]
    link = [zero, -(qm - q), a, zero, zero, v, at.sign(v, a), GRAVITY * np.cos(q), GRAVITY * np.sin(q)]
    torque = recording.motor_torque
    if measurement:
        names += ["offset", "torque_delay", "K link_zero", "K link_skew"]
        motor += [one, -at.derivative(torque, 1), one, -v]
        link += [zero, zero, -one, v]
    columns = tuple(names)
    return (np.column_stack(motor), torque, columns), (np.column_stack(link), zero, columns)


def motor_only(recording: Recording, at: Observation) -> Equations:
    """Eqs. 18 to 20: the link's position eliminated, gravity and the link's Coulomb friction neglected.

    Gamma_m = - X1 Gamma_m'' - X2 Gamma_m' + X3 qm'''' + X4 qm''' + X5 qm'' + X6 qm' + X7 sign(qm')
    """
    qm, torque = recording.motor_position, recording.motor_torque
    q1, q2, q3, q4 = (at.derivative(qm, k) for k in (1, 2, 3, 4))
    columns = [-at.derivative(torque, 2), -at.derivative(torque, 1), q4, q3, q2, q1, at.sign(q1, q2)]
    return np.column_stack(columns), at.derivative(torque, 0), ("X1", "X2", "X3", "X4", "X5", "X6", "X7")


def rigid(recording: Recording, at: Observation, *, gravity: bool) -> Equations:
    """Gamma = J q'' + FV q' + FS sign(q') + offset, with `gravity` MX g cos q + MY g sin q in addition."""
    q, v, a = (at.derivative(recording.motor_position, k) for k in (0, 1, 2))
    columns = [a, v, at.sign(v, a), np.ones_like(q)]
    names = ["J", "FV", "FS", "offset"]
    if gravity:
        columns += [GRAVITY * np.cos(q), GRAVITY * np.sin(q)]
        names += ["MX", "MY"]
    return np.column_stack(columns), recording.motor_torque, tuple(names)
