"""Two masses and a spring, stepped in time: position Verlet with dry friction as an impulse that cannot reverse motion.

Each step drifts half a step, kicks both masses with the forces there, and drifts on: second order, symplectic without
friction. Viscous friction enters the kick implicitly; dry friction removes at most the momentum there is, so a mass at
rest sticks exactly until it is pushed harder than its friction. Shares nothing with `flex_ident.simulation`.
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.recording import Floats
from flex_ident.virtual_joint.compiled import compiled
from flex_ident.virtual_joint.physics import GRAVITY, P

JM, STIFFNESS, JL = int(P.MOTOR_INERTIA), int(P.STIFFNESS), int(P.LINK_INERTIA)
FVM, FSM, FV, FS = int(P.MOTOR_VISCOUS), int(P.MOTOR_DRY), int(P.LINK_VISCOUS), int(P.LINK_DRY)
MX, MY, CONSTANT = int(P.MASS_X), int(P.MASS_Y), int(P.CONSTANT)
ST, ST_V, ST_L, ST_VL = int(P.STRIBECK), int(P.STRIBECK_SPEED), int(P.STRIBECK_LINK), int(P.STRIBECK_SPEED_LINK)
AS, AS_L, QU, QU_L = int(P.ASYMMETRY), int(P.ASYMMETRY_LINK), int(P.QUADRATIC), int(P.QUADRATIC_LINK)
LF, LF_L, WARM = int(P.LOAD_FRICTION), int(P.LOAD_FRICTION_LINK), int(P.WARMING)
CUBIC, PLAY, DAHL, DAHL_D = int(P.CUBIC), int(P.PLAY), int(P.DAHL_TORQUE), int(P.DAHL_DEFLECTION)
DAMP, RIP, RIP_C, RIP_P = int(P.SPRING_DAMPING), int(P.RIPPLE), int(P.RIPPLE_CYCLES), int(P.RIPPLE_PHASE)
GE, GE_C, GE_P = int(P.GEAR_ERROR), int(P.GEAR_CYCLES), int(P.GEAR_PHASE)
J2, K2, D2 = int(P.SECOND_INERTIA), int(P.SECOND_STIFFNESS), int(P.SECOND_DAMPING)

STATE = 8
"""Motor, link and second mass, position and velocity each, then Dahl state and deflection."""


@compiled
def deflection(p: Floats, motor: float, link: float) -> float:
    """Deflection of the spring, transmission error included, rad."""
    if p[GE] == 0.0:
        return motor - link
    return motor + p[GE] * math.sin(p[GE_C] * motor + p[GE_P]) - link


@compiled
def elastic_torque(p: Floats, d: float, bristle: float) -> float:
    """Torque of the spring at deflection `d` with its play, hardening and Dahl part, N m."""
    half = 0.5 * p[PLAY]
    engaged = d - half if d > half else (d + half if d < -half else 0.0)
    return p[STIFFNESS] * engaged + p[CUBIC] * d * d * d + p[DAHL] * bristle


@compiled
def stopped_or_slowed(velocity: float, loss: float) -> float:
    """A velocity after dry friction took `loss` of it, never beyond standstill."""
    if abs(velocity) <= loss:
        return 0.0
    return velocity - loss if velocity > 0.0 else velocity + loss


@compiled
def stepped(p: Floats, state: Floats, torque: float, h: float, warm: float) -> None:
    """Advance `state` (STATE,) by `h` s under the motor's `torque`, N m."""
    flexible = p[STIFFNESS] > 0.0
    second = p[J2] > 0.0
    a, va, b, vb, c, vc = state[0], state[1], state[2], state[3], state[4], state[5]
    a += 0.5 * h * va
    b += 0.5 * h * vb
    c += 0.5 * h * vc
    gear_rate = 1.0 + p[GE] * p[GE_C] * math.cos(p[GE_C] * a + p[GE_P]) if p[GE] != 0.0 else 1.0
    shaft = 0.0
    if flexible:
        d = deflection(p, a, b)
        if p[DAHL] > 0.0 and p[DAHL_D] > 0.0:
            change = d - state[7]
            if change != 0.0:
                goal = 1.0 if change > 0.0 else -1.0
                state[6] = goal + (state[6] - goal) * math.exp(-abs(change) / p[DAHL_D])
        state[7] = d
        shaft = elastic_torque(p, d, state[6]) + p[DAMP] * (gear_rate * va - vb)
        weight = GRAVITY * (p[MX] * math.cos(b) + p[MY] * math.sin(b))
    else:
        weight = GRAVITY * (p[MX] * math.cos(a) + p[MY] * math.sin(a))
    load = shaft if flexible else weight
    push = torque - gear_rate * shaft - p[CONSTANT] - warm * (p[AS] * abs(va) + p[QU] * va * abs(va))
    if not flexible:
        push -= weight
    if p[RIP] != 0.0:
        push -= p[RIP] * math.sin(p[RIP_C] * a + p[RIP_P])
    half_damping = 0.5 * h * warm * p[FVM]
    free = (va * (p[JM] - half_damping) + h * push) / (p[JM] + half_damping)
    dry = p[FSM] + p[LF] * abs(load)
    if p[ST] != 0.0 and p[ST_V] > 0.0:
        dry += p[ST] * math.exp(-((va / p[ST_V]) ** 2))
    va = stopped_or_slowed(free, h * warm * dry / (p[JM] + half_damping))
    if flexible:
        push = shaft - weight - warm * (p[AS_L] * abs(vb) + p[QU_L] * vb * abs(vb))
        if second:
            back = p[K2] * (b - c) + p[D2] * (vb - vc)
            push -= back
            vc += h * back / p[J2]
        half_damping = 0.5 * h * warm * p[FV]
        free = (vb * (p[JL] - half_damping) + h * push) / (p[JL] + half_damping)
        dry = p[FS] + p[LF_L] * abs(shaft)
        if p[ST_L] != 0.0 and p[ST_VL] > 0.0:
            dry += p[ST_L] * math.exp(-((vb / p[ST_VL]) ** 2))
        vb = stopped_or_slowed(free, h * warm * dry / (p[JL] + half_damping))
    a += 0.5 * h * va
    if flexible:
        b += 0.5 * h * vb
        c += 0.5 * h * vc
    else:
        b, vb, c, vc = a, va, a, va
    state[0], state[1], state[2], state[3], state[4], state[5] = a, va, b, vb, c, vc


@compiled
def rest_link(p: Floats, motor: float) -> float:
    """Where the link hangs still behind a motor at `motor`, rad."""
    if p[STIFFNESS] <= 0.0:
        return motor
    link = motor
    for _ in range(50):
        weight = GRAVITY * (p[MX] * math.cos(link) + p[MY] * math.sin(link))
        play = 0.5 * p[PLAY] if weight > 0.0 else -0.5 * p[PLAY]
        link = motor - weight / p[STIFFNESS] - (play if p[PLAY] > 0.0 else 0.0)
    return link


def state_at_rest(p: Floats, motor: float) -> Floats:
    """The state (STATE,) of a joint that hangs still with its motor at `motor`, rad."""
    link = float(rest_link(p, motor))
    state = np.zeros(STATE)
    state[0], state[2], state[4] = motor, link, link
    state[7] = float(deflection(p, motor, link))
    return state


def holding_torque(p: Floats, motor: float) -> float:
    """Motor torque, N m, that holds the joint at rest at `motor`, friction left out."""
    link = float(rest_link(p, motor))
    return float(GRAVITY * (p[MX] * math.cos(link) + p[MY] * math.sin(link)) + p[CONSTANT])
