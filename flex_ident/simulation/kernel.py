"""The link, driven through the spring by the recorded motor position: eq. 5 integrated forward.

Runge-Kutta 4 between the reversals of the link; the sign in Coulomb friction is constant inside a step, and a step in
which the velocity would change sign is cut there, so that the result is smooth in the parameters. At rest the link
sticks until the torque on it exceeds the Coulomb friction. The Dahl state of the hysteresis is updated exactly in
deflection (explicit steps in time diverge).
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.compiled import compiled
from flex_ident.simulation.curves import tabulated
from flex_ident.simulation.terms import SPRING_CURVE, Term

K, K3, HALF_GAP = int(Term.STIFFNESS), int(Term.CUBIC_STIFFNESS), int(Term.HALF_GAP)
ZONE, ZONE_D = int(Term.SOFT_ZONE_SHARE), int(Term.SOFT_ZONE_DEFLECTION)
RELAX, RELAX_T = int(Term.RELAXING_STIFFNESS), int(Term.RELAXATION_TIME)
HYS, HYS_D, DAMP = int(Term.HYSTERESIS_TORQUE), int(Term.HYSTERESIS_DEFLECTION), int(Term.SPRING_DAMPING)
JL, FV, FS = int(Term.LINK_INERTIA), int(Term.LINK_VISCOUS), int(Term.LINK_COULOMB)
GX, GY = int(Term.GRAVITY_COS), int(Term.GRAVITY_SIN)
FV_ASYM, FV_QUAD = int(Term.LINK_VISCOUS_ASYMMETRY), int(Term.LINK_VISCOUS_QUADRATIC)
STRIBECK, STRIBECK_V = int(Term.LINK_STRIBECK), int(Term.LINK_STRIBECK_VELOCITY)
LOAD, RATE = int(Term.LINK_LOAD_FRICTION), int(Term.FRICTION_RATE)
J2, K2, D2 = int(Term.SECOND_INERTIA), int(Term.SECOND_STIFFNESS), int(Term.SECOND_DAMPING)
CURVE = int(SPRING_CURVE.points)
K_X2, K_Y2 = int(Term.STIFFNESS_COS_2), int(Term.STIFFNESS_SIN_2)
CABLE, CABLE_PULL = int(Term.CABLE_STIFFNESS), int(Term.CABLE_TORQUE)
CABLE_X2, CABLE_Y2 = int(Term.CABLE_COS_2), int(Term.CABLE_SIN_2)
SOFT, SOFT_T = int(Term.SOFT_FRICTION), int(Term.SOFT_FRICTION_TIME)
TURNOVER = int(Term.LINK_TURNOVER)
Q0, V0 = int(Term.INITIAL_DEFLECTION), int(Term.INITIAL_VELOCITY)
RUNAWAY = 100.0
"""Position over its start (or ten) from which parameters are out of all reason."""


@compiled
def dahl_state(z: float, change: float, scale: float) -> float:
    """The Dahl state after the deflection changed monotonically by `change`: exact solution of dz/dd."""
    if scale <= 0.0 or change == 0.0:
        return z
    goal = 1.0 if change > 0.0 else -1.0
    return goal + (z - goal) * math.exp(-abs(change) / scale)


@compiled
def relaxed(p: Floats, y: float, change: float, time: float) -> float:
    """Deflection of the part that relaxes, `time` s after it was `y`, the spring bent by `change` evenly meanwhile."""
    if p[RELAX] == 0.0 or time <= 0.0 or p[RELAX_T] <= 0.0:
        return y
    x = time / p[RELAX_T]
    decay = math.exp(-x)
    return float(y * decay + change * (1.0 - decay) / x)


@compiled
def spring_torque(p: Floats, at: float, d: float, rate: float, z: float, y: float) -> float:
    """Torque through the transmission at deflection `d`, its `rate`, Dahl state `z`, and `y` of what relaxes; `at`: the
    angle of the motor's side."""
    e = d
    gap = p[HALF_GAP]
    if gap > 0.0:
        if d > gap:
            e = d - gap
        elif d < -gap:
            e = d + gap
        else:
            e = 0.0
    if p[ZONE] != 0.0 and p[ZONE_D] > 0.0:
        e -= p[ZONE] * e / math.sqrt(1.0 + (e / p[ZONE_D]) ** 2)
    torque = p[K] * e + p[K3] * d * d * d + p[DAMP] * rate + p[HYS] * z + p[RELAX] * y
    if p[K_X2] != 0.0 or p[K_Y2] != 0.0:
        torque += (p[K_X2] * (math.cos(2.0 * at) - 1.0) + p[K_Y2] * math.sin(2.0 * at)) * d
    if p[CURVE] > 0.0:
        torque += tabulated(p, CURVE, d)
    return float(torque)


@compiled
def gravity(p: Floats, q: float) -> tuple[float, float]:
    """Torque of gravity (eq. 7) and of a cable to ground at link position `q`, N m, and its derivative by position."""
    load, slope = p[CABLE_PULL] + p[CABLE] * q, p[CABLE]
    if p[GX] != 0.0 or p[GY] != 0.0:
        cosine, sine = math.cos(q), math.sin(q)
        load += p[GX] * cosine + p[GY] * sine
        slope += p[GY] * cosine - p[GX] * sine
    if p[CABLE_X2] != 0.0 or p[CABLE_Y2] != 0.0:
        cosine, sine = math.cos(2.0 * q), math.sin(2.0 * q)
        load += p[CABLE_X2] * cosine + p[CABLE_Y2] * sine
        slope += 2.0 * (p[CABLE_Y2] * cosine - p[CABLE_X2] * sine)
    return float(load), float(slope)


@compiled
def free_torque(
    p: Floats, moved: float, v: float, deflection2: float, rate2: float, tau: float, time: float, load: float,
    slope: float,
) -> float:  # fmt: skip
    """Torque on the link, its dry friction left out.

    `load` and `slope` are gravity's at the step's start, `moved` what the link has moved since: the expansion to second
    order is exact to 1e-10 of gravity (5e-7 of a cable's torque) at 1 rad/s and 1 ms, and four times as fast as sine
    and cosine.
    """
    torque = tau - (1.0 + p[RATE] * time) * (p[FV] * v + p[FV_ASYM] * abs(v) + p[FV_QUAD] * v * abs(v))
    torque -= load * (1.0 - 0.5 * moved * moved) + slope * moved
    if p[J2] != 0.0:
        torque += p[K2] * deflection2 + p[D2] * rate2
    return float(torque)


@compiled
def dry_friction(p: Floats, v: float, tau: float, time: float) -> float:
    """Magnitude of the link's dry friction at speed `v` under transmitted torque `tau`."""
    level = p[FS] + p[LOAD] * abs(tau)
    if p[STRIBECK] != 0.0 and p[STRIBECK_V] > 0.0:
        level += p[STRIBECK] * math.exp(-((v / p[STRIBECK_V]) ** 2))
    level *= 1.0 + p[RATE] * time
    if p[TURNOVER] > 0.0:
        level *= math.tanh(abs(v) / p[TURNOVER])
    return float(level) if level > 0.0 else 0.0


@compiled
def soft_friction(p: Floats, push: float, v: float, hold: float) -> float:
    """The link's dry friction as a soft constraint, which takes a share of what would move the link, at most `hold`."""
    wanted = (push + p[JL] * v / p[SOFT_T]) / (1.0 + p[SOFT])
    return float(min(max(wanted, -hold), hold))


@compiled
def interpolated(left: float, middle: float, right: float, x: float) -> float:
    """The parabola through values at 0, 1/2 and 1, at `x`."""
    return left + x * ((4.0 * middle - 3.0 * left - right) + x * 2.0 * (left - 2.0 * middle + right))


@compiled
def first_state(p: Floats, base: float, base_rate: float) -> tuple[float, float]:
    """Link position and velocity at the start: at rest on the linear spring, plus the estimated deviation."""
    stiffness = p[K] if p[K] > 0.0 else 1.0
    q = base
    for _ in range(8):
        q = base - gravity(p, q)[0] / stiffness
    gap = p[HALF_GAP]
    if gap > 0.0:
        q -= gap if gravity(p, q)[0] > 0.0 else -gap
    v = base_rate + p[V0]
    return float(q + p[Q0]), float(v if abs(v) >= 1e-12 else 0.0)


@compiled
def link_step(
    p: Floats, q: float, v: float, q2: float, v2: float, z: float, y: float, b0: float, b1: float, b2: float, r0: float,
    r1: float, r2: float, step: float, time: float, against: float,
) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """State of the link, the second mass, the hysteresis and what relaxes one step later.

    The motor's side of the spring is at `b0`, `b1`, `b2` at the step's start, middle and end; its rate is `r0` to `r2`.
    `against`: a further torque that the link works against.
    """
    second = p[J2] != 0.0
    inverse_inertia = 1.0 / p[JL]
    inverse_second = 1.0 / p[J2] if second else 0.0
    start = 0.0
    q_start = q
    load, slope = gravity(p, q)
    load += against
    soft = p[SOFT] > 0.0
    for _ in range(4):
        if start >= 1.0:
            break
        x0 = start
        sign = 0.0
        if v > 0.0:
            sign = 1.0
        elif v < 0.0:
            sign = -1.0
        elif not soft:
            # At rest: does the link stick until the end of the step?
            here = interpolated(b0, b1, b2, x0)
            tau = spring_torque(p, here, here - q, interpolated(r0, r1, r2, x0), z, y)
            push = free_torque(p, q - q_start, 0.0, q2 - q, v2, tau, time, load, slope)
            hold = dry_friction(p, 0.0, tau, time)
            if abs(push) > hold:
                sign = 1.0 if push > 0.0 else -1.0
            else:
                z_end = dahl_state(z, b2 - here, p[HYS_D])
                y_end = relaxed(p, y, b2 - here, (1.0 - x0) * step)
                tau_end = spring_torque(p, b2, b2 - q, r2, z_end, y_end)
                push_end = free_torque(p, q - q_start, 0.0, q2 - q, v2, tau_end, time, load, slope)
                hold_end = dry_friction(p, 0.0, tau_end, time)
                excess, excess_end = abs(push) - hold, abs(push_end) - hold_end
                fraction = 1.0
                if excess_end > 0.0:
                    fraction = -excess / (excess_end - excess)
                x1 = x0 + fraction * (1.0 - x0)
                there = interpolated(b0, b1, b2, x1)
                z = dahl_state(z, there - here, p[HYS_D])
                y = relaxed(p, y, there - here, (x1 - x0) * step)
                if second:
                    h = (x1 - x0) * step
                    a2 = -(p[K2] * (q2 - q) + p[D2] * v2) * inverse_second
                    v2 += h * a2
                    q2 += h * v2
                start = x1
                if fraction >= 1.0:
                    break
                sign = 1.0 if push_end > 0.0 else -1.0
                x0 = x1
                if x0 >= 1.0 - 1e-9:
                    break
        span = 1.0 - x0
        q_old, v_old, q2_old, v2_old, z_old, y_old = q, v, q2, v2, z, y
        d_old = interpolated(b0, b1, b2, x0) - q
        reached = 1.0
        for attempt in range(2):
            h = span * step * reached
            dq = dv = dq2 = dv2 = 0.0
            kq = kv = kq2 = kv2 = 0.0
            for stage in range(4):
                along = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
                where, share = x0 + along * span * reached, along * h
                weight = 1.0 if stage == 0 or stage == 3 else 2.0
                sq, sv = q_old + share * kq, v_old + share * kv
                sq2, sv2 = q2_old + share * kq2, v2_old + share * kv2
                sd = interpolated(b0, b1, b2, where) - sq
                sz = dahl_state(z_old, sd - d_old, p[HYS_D])
                sy = relaxed(p, y_old, sd - d_old, share)
                tau = spring_torque(p, sd + sq, sd, interpolated(r0, r1, r2, where) - sv, sz, sy)
                kq = sv
                push = free_torque(p, sq - q_start, sv, sq2 - sq, sv2 - sv, tau, time, load, slope)
                dry = dry_friction(p, sv, tau, time)
                kv = (push - (soft_friction(p, push, sv, dry) if soft else sign * dry)) * inverse_inertia
                if second:
                    kq2 = sv2
                    kv2 = -(p[K2] * (sq2 - sq) + p[D2] * (sv2 - sv)) * inverse_second
                dq += weight * kq
                dv += weight * kv
                dq2 += weight * kq2
                dv2 += weight * kv2
            q, v = q_old + h * dq / 6.0, v_old + h * dv / 6.0
            q2, v2 = q2_old + h * dq2 / 6.0, v2_old + h * dv2 / 6.0
            if attempt == 0 and not soft and v * sign < 0.0 and v_old != 0.0:
                reached = v_old / (v_old - v)  # the velocity changes sign here: step again, up to there
                continue
            break
        bent = interpolated(b0, b1, b2, x0 + span * reached) - q - d_old
        z = dahl_state(z_old, bent, p[HYS_D])
        y = relaxed(p, y_old, bent, span * reached * step)
        if reached < 1.0 or (v_old == 0.0 and v * sign < 0.0 and not soft):
            v = 0.0
        start = x0 + span * reached
    return q, v, q2, v2, z, y


@compiled
def simulated_link(
    p: Floats, base: Floats, base_rate: Floats, step: float, torque: Floats, position: Floats, velocity: Floats
) -> int:
    """Fill spring torque, link position and velocity, each (n,), at every step of `step` s; returns steps taken.

    `base` and `base_rate` (2 n - 1,): position and velocity of the motor's side of the spring, at half steps.
    Returns early, the rest left NaN, when the link runs away (parameters out of all reason).
    """
    n = torque.size
    q, v = first_state(p, base[0], base_rate[0])
    q2, v2, z, y = q, v, 0.0, 0.0
    bound = RUNAWAY * (10.0 + abs(q))
    for k in range(n):
        torque[k] = spring_torque(p, base[2 * k], base[2 * k] - q, base_rate[2 * k] - v, z, y)
        position[k], velocity[k] = q, v
        if k == n - 1:
            break
        q, v, q2, v2, z, y = link_step(
            p, q, v, q2, v2, z, y, base[2 * k], base[2 * k + 1], base[2 * k + 2], base_rate[2 * k],
            base_rate[2 * k + 1], base_rate[2 * k + 2], step, k * step, 0.0,
        )  # fmt: skip
        if not abs(q) < bound:
            for j in range(k + 1, n):
                torque[j], position[j], velocity[j] = np.nan, np.nan, np.nan
            return k
    return n
