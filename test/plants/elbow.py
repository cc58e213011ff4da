"""An elbow on a shoulder that is braked and yields: two flexible joints of a planar arm, driven at the second motor.

Nothing is shared with the estimator: both links and the elbow's motor forward in time, semi-implicit Euler at 20 kHz,
the motor's dry friction by what stops within a step, the link's a steep tanh of speed. Angles are small enough for a
constant matrix of inertia; the rotor is geared high, so that it feels the angle to its own link alone (Spong 1987).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from flex_ident.recording import Floats, Recording

JM, K, FVM, FSM, FV, FS = 1.0, 9000.0, 9.0, 4.5, 2.0, 1.2
SHOULDER, COUPLING, LINK = 4.0, 1.5, 0.66
"""Inertia of both links about the shoulder, of the second between both angles, and about the elbow, kg m^2."""
RATE_HZ, STEPS, DURATION_S = 500, 40, 24.0


@njit(cache=True)  # type: ignore[untyped-decorator]
def _run(reference: Floats, shoulder: float) -> Floats:
    h = 1.0 / (RATE_HZ * STEPS)
    out = np.zeros((reference.size, 3))
    q1 = q2 = qm = v1 = v2 = vm = integral = 0.0
    determinant = SHOULDER * LINK - COUPLING**2
    loss = 0.004 * shoulder
    for k in range(reference.size):
        ahead = (reference[min(k + 1, reference.size - 1)] - reference[max(k - 1, 0)]) * 0.5 * RATE_HZ
        error = 25.0 * (reference[k] - qm) + ahead - vm
        integral += 900.0 * error / RATE_HZ
        torque = 130.0 * error + integral
        out[k] = qm, q2, torque
        for _ in range(STEPS):
            spring = K * (qm - q2)
            t1 = -shoulder * q1 - loss * v1
            t2 = spring - FV * v2 - FS * math.tanh(v2 / 1e-4)
            v1 += h * (LINK * t1 - COUPLING * t2) / determinant
            v2 += h * (SHOULDER * t2 - COUPLING * t1) / determinant
            free = vm + h * (torque - spring - FVM * vm) / JM
            vm = free - min(max(free, -h * FSM / JM), h * FSM / JM)
            q1, q2, qm = q1 + h * v1, q2 + h * v2, qm + h * vm
    return out


def elbow_recording(shoulder: float, *, link: bool = True, seed: int = 0) -> Recording:
    """The elbow's recording on a shoulder of that stiffness, N m/rad; 20-bit encoders, the motor's before a gear."""
    t = np.arange(0.0, DURATION_S, 1.0 / RATE_HZ)
    start, end = 0.4, 32.0
    phase = 2.0 * math.pi * start * DURATION_S / math.log(end / start) * ((end / start) ** (t / DURATION_S) - 1.0)
    frequency = start * (end / start) ** (t / DURATION_S)
    amplitude = np.minimum(0.25, 0.7 / (2.0 * math.pi * frequency))
    motor, position, torque = _run(amplitude * np.sin(phase), shoulder).T
    rng = np.random.default_rng(seed)
    step = 2.0 * math.pi / 2**20
    return Recording(
        "elbow",
        float(RATE_HZ),
        np.round(motor / (0.01 * step)) * 0.01 * step,
        torque + 0.005 * float(np.std(torque)) * rng.standard_normal(t.size),
        link_position=np.round(position / step) * step if link else None,
    )


def seen_stiffness(shoulder: float) -> float:
    """The stiffness, N m/rad, that the first mode at a motor that is held is of, for the elbow's own inertia."""
    inertia = np.array([[SHOULDER, COUPLING], [COUPLING, LINK]])
    modes = np.linalg.eigvals(np.linalg.solve(inertia, np.diag([shoulder, K])))
    return float(np.min(modes.real)) * LINK
