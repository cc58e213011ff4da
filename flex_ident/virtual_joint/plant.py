"""Two masses, a spring and the drive that moves them, stepped in time: all that is compiled is in this file.

The plant is position Verlet with dry friction as an impulse that cannot reverse motion: each step drifts half a step,
kicks both masses with the forces there, and drifts on: second order, symplectic without friction. Viscous friction
enters the kick implicitly; dry friction removes at most the momentum there is, so a mass at rest sticks exactly until
it is pushed harder than its friction. Shares nothing with `flex_ident.simulation`.

numba's cache notices a change of a function's own file only: functions that call each other stay together here.
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
LF, LF_L = int(P.LOAD_FRICTION), int(P.LOAD_FRICTION_LINK)
WARM, WARM_M = int(P.WARMING), int(P.WARMING_MOTOR)
CUBIC, PLAY, DAHL, DAHL_D = int(P.CUBIC), int(P.PLAY), int(P.DAHL_TORQUE), int(P.DAHL_DEFLECTION)
DAMP, RIPPLE, GEAR = int(P.SPRING_DAMPING), int(P.RIPPLE), int(P.GEAR_ERROR)
BEND, BEND_ST, BEND_V = int(P.BRISTLE_DEFLECTION), int(P.BRISTLE_STRIBECK), int(P.BRISTLE_STRIBECK_SPEED)
JB, KB, DB = int(P.MOUNT_INERTIA), int(P.MOUNT_STIFFNESS), int(P.MOUNT_DAMPING)
SOFT, SOFT_T = int(P.SOFTNESS), int(P.SOFT_TIME)
J2, K2, D2, LIMIT = int(P.SECOND_INERTIA), int(P.SECOND_STIFFNESS), int(P.SECOND_DAMPING), int(P.DRIVE_LIMIT)
FRICTION_TABLE, ANGLE_TABLE, SPRING_TABLE = int(P.FRICTION_TABLE), int(P.ANGLE_TABLE), int(P.SPRING_TABLE)
CABLE, PULL = int(P.CABLE_STIFFNESS), int(P.CABLE_TORQUE)
CABLE_C, CABLE_S = int(P.CABLE_COSINE), int(P.CABLE_SINE)
WAVE = int(P.FRICTION_WAVE)
ZONE, ZONE_D = int(P.SOFT_SHARE), int(P.SOFT_DEFLECTION)
MOTOR_READ, LINK_READ = int(P.MOTOR_ENCODER), int(P.LINK_ENCODER)
RELAX, RELAX_T = int(P.RELAXING), int(P.RELAXATION)
IRON, DROOP, LAG = int(P.IRON_LOSS), int(P.TORQUE_DROOP), int(P.EFFORT_LAG)
GAIN, SHIFT = int(P.GAIN_RATE), int(P.OFFSET_RATE)
STIFF_C, STIFF_S = int(P.STIFFNESS_COSINE), int(P.STIFFNESS_SINE)

HARMONICS = 5
"""Of what is periodic in the motor's angle: amplitude, cycles a turn and phase, one after the other from the first."""
STATE = 20
"""Motor, link and second mass, position and velocity each; Dahl state, deflection; the drive's integral, smoothed
command and its rate; time; the command before and the one before that; torque of the motor's bristles; the base's
angle, rate and acceleration; torque behind the driver's low-pass; deflection of the spring's part that relaxes."""
INTEGRAL, SMOOTH, SMOOTH_RATE, TIME, BEFORE, EARLIER, BENT = 8, 9, 10, 11, 12, 13, 14
BASE, BASE_RATE, BASE_ACCELERATION, SLOW, PART = 15, 16, 17, 18, 19
ROW = 5
"""What a cycle of the drive leaves: motor position and velocity as read, link position and velocity, torque."""
POSITION, VELOCITY, EFFORT = 0, 1, 2
"""What is commanded."""


@compiled
def weight(p: Floats, angle: float) -> float:
    """Torque of gravity (eq. 7) and of a cable to ground at `angle`, N m."""
    cable = p[PULL] + p[CABLE] * angle
    if p[CABLE_C] != 0.0 or p[CABLE_S] != 0.0:
        cable += p[CABLE_C] * math.cos(2.0 * angle) + p[CABLE_S] * math.sin(2.0 * angle)
    return float(GRAVITY * (p[MX] * math.cos(angle) + p[MY] * math.sin(angle)) + cable)


@compiled
def periodic(p: Floats, first: int, angle: float) -> float:
    """The harmonics that begin at index `first`, at the motor's `angle`, rad."""
    total = 0.0
    for i in range(first, first + 3 * HARMONICS, 3):
        if p[i] != 0.0:
            total += p[i] * math.sin(p[i + 1] * angle + p[i + 2])
    return total


@compiled
def parabola_slope(x0: float, y0: float, x1: float, y1: float, x2: float, y2: float, x: float) -> float:
    """Slope at `x` of the parabola through three points."""
    a = y0 * (2.0 * x - x1 - x2) / ((x0 - x1) * (x0 - x2))
    b = y1 * (2.0 * x - x0 - x2) / ((x1 - x0) * (x1 - x2))
    return float(a + b + y2 * (2.0 * x - x0 - x1) / ((x2 - x0) * (x2 - x1)))


@compiled
def table_slope(t: Floats, i: int, x: float) -> float:
    """Slope at point `i` of a table (k, 2) that is at `x`: of the parabola through it and its neighbours."""
    k = t.shape[0]
    if k == 2:
        return float((t[1, 1] - t[0, 1]) / (t[1, 0] - t[0, 0]))
    j = min(max(i, 1), k - 2)
    return parabola_slope(t[j - 1, 0], t[j - 1, 1], t[j, 0], t[j, 1], t[j + 1, 0], t[j + 1, 1], x)


@compiled
def looked_up(t: Floats, x: float) -> float:
    """The torque of a table (k, 2) of places and torques at `x`: a cubic between two points, level beyond the ends."""
    k = t.shape[0]
    if k == 1 or x <= t[0, 0]:
        return float(t[0, 1])
    if x >= t[k - 1, 0]:
        return float(t[k - 1, 1])
    i = int(np.searchsorted(t[:, 0], x, side="right")) - 1
    h = t[i + 1, 0] - t[i, 0]
    u = (x - t[i, 0]) / h
    a, b = table_slope(t, i, t[i, 0]), table_slope(t, i + 1, t[i + 1, 0])
    one = (1.0 + 2.0 * u) * (1.0 - u) ** 2 * t[i, 1] + u * (1.0 - u) ** 2 * h * a
    return float(one + u * u * (3.0 - 2.0 * u) * t[i + 1, 1] - u * u * (1.0 - u) * h * b)


@compiled
def table(p: Floats, first: int) -> Floats:
    """Places and torques (k, 2) of the table that begins at index `first`."""
    return p[first + 1 : first + 1 + 2 * int(p[first])].reshape(-1, 2)


@compiled
def friction_tables(p: Floats, forwards: bool) -> Floats:
    """The part (k, 2) of the friction table that is of one direction."""
    whole = table(p, FRICTION_TABLE)
    split = int(np.searchsorted(whole[:, 0], 0.0))
    return whole[split:] if forwards else whole[:split]


@compiled
def ratio_of(p: Floats, first: int, angle: float) -> float:
    """Movement of what has an error by the harmonics that begin at index `first` over that of `angle`, rad."""
    ratio = 1.0
    for i in range(first, first + 3 * HARMONICS, 3):
        if p[i] != 0.0:
            ratio += p[i] * p[i + 1] * math.cos(p[i + 1] * angle + p[i + 2])
    return ratio


@compiled
def deflection(p: Floats, motor: float, link: float) -> float:
    """Deflection of the spring, transmission error included, rad."""
    return motor + periodic(p, GEAR, motor) - link


@compiled
def elastic_torque(p: Floats, d: float, bristle: float) -> float:
    """Torque of the spring at deflection `d` with its play, soft zone, hardening and Dahl part, N m."""
    half = 0.5 * p[PLAY]
    engaged = d - half if d > half else (d + half if d < -half else 0.0)
    if p[ZONE] > 0.0:
        engaged *= 1.0 - p[ZONE] / math.hypot(1.0, engaged / p[ZONE_D])
    torque = p[STIFFNESS] * engaged + p[CUBIC] * d * d * d + p[DAHL] * bristle
    if p[SPRING_TABLE] > 0.0:
        law = table(p, SPRING_TABLE)
        inside = min(max(d, law[0, 0]), law[-1, 0])
        torque += looked_up(law, inside)
        if law.shape[0] > 1 and d != inside:
            torque += table_slope(law, 0 if d < inside else law.shape[0] - 1, inside) * (d - inside)
    return float(torque)


@compiled
def uneven(p: Floats, motor: float) -> float:
    """Stiffness of the spring with the motor at an angle, less that at none, N m/rad."""
    turned = math.sin(motor)
    return float(2.0 * turned * (p[STIFF_S] * math.cos(motor) - p[STIFF_C] * turned))


@compiled
def dahl_state(p: Floats, z: float, change: float) -> float:
    """Dahl's state after the deflection changed by `change`, rad."""
    if p[DAHL_D] <= 0.0 or change == 0.0:
        return z
    goal = 1.0 if change > 0.0 else -1.0
    return goal + (z - goal) * math.exp(-abs(change) / p[DAHL_D])


@compiled
def kicked(
    velocity: float, inertia: float, push: float, viscous: float, dry: float, peak: float, peak_speed: float,
    h: float,
) -> float:  # fmt: skip
    """Velocity after `h` s of `push`, N m, against viscous and dry friction (with a Stribeck `peak`)."""
    damping = 0.5 * h * viscous
    free = (velocity * (inertia - damping) + h * push) / (inertia + damping)
    if peak != 0.0 and peak_speed > 0.0:
        dry += peak * math.exp(-((velocity / peak_speed) ** 2))
    loss = h * max(dry, 0.0) / (inertia + damping)
    if abs(free) <= loss:
        return 0.0
    return free - loss if free > 0.0 else free + loss


@compiled
def bristle_force(p: Floats, force: float, velocity: float, dry: float, h: float) -> float:
    """Torque of the bristles after `h` s at a constant velocity, `dry` the friction that they slide under (LuGre).

    Backward Euler in time, which never overshoots, however stiff the bristles are.
    """
    at_rest = p[FSM] + p[ST] + p[BEND_ST]
    level = dry
    if p[ST] != 0.0 and p[ST_V] > 0.0:
        level += p[ST] * math.exp(-((velocity / p[ST_V]) ** 2))
    if p[BEND_ST] != 0.0 and p[BEND_V] > 0.0:
        level += p[BEND_ST] * math.exp(-((velocity / p[BEND_V]) ** 2))
    stiffness = at_rest / p[BEND]
    return float((force + h * stiffness * velocity) / (1.0 + h * stiffness * abs(velocity) / max(level, 1e-12)))


@compiled
def softly_kicked(
    p: Floats, velocity: float, inertia: float, push: float, viscous: float, dry: float, h: float
) -> float:
    """Velocity after `h` s of `push`, N m, where dry friction is a constraint that takes a share of what would move."""
    free = push - viscous * velocity
    wanted = (free + inertia * velocity / p[SOFT_T]) / (1.0 + p[SOFT])
    return float(velocity + h * (free - min(max(wanted, -dry), dry)) / inertia)


@compiled
def stepped(p: Floats, state: Floats, torque: float, h: float, warm: float) -> None:
    """Advance the masses in `state` (STATE,) by `h` s under the motor's `torque`, N m.

    All friction is times `warm`; the motor's may warm up by itself as well.
    """
    a, va, b, vb, c, vc = state[0], state[1], state[2], state[3], state[4], state[5]
    flexible = p[STIFFNESS] > 0.0
    va_before, vb_before, swing = va, vb, state[BASE_ACCELERATION]
    a += 0.5 * h * va
    b += 0.5 * h * vb
    c += 0.5 * h * vc
    hot = warm + p[WARM_M] * state[TIME]
    push = torque - p[CONSTANT] - hot * (p[AS] * abs(va) + p[QU] * va * abs(va))
    push -= periodic(p, RIPPLE, a) + p[JM] * swing
    if flexible:
        gear = ratio_of(p, GEAR, a)
        d = deflection(p, a, b)
        state[6] = dahl_state(p, state[6], d - state[7])
        if p[RELAX] > 0.0:
            lost = 0.5 * h / p[RELAX_T]
            state[PART] = ((1.0 - lost) * state[PART] + d - state[7]) / (1.0 + lost)
        state[7] = d
        load = p[RELAX] * state[PART] + elastic_torque(p, d, state[6]) + p[DAMP] * (gear * va - vb)
        load += uneven(p, a) * d
        push -= gear * load
    else:
        load = weight(p, a)
        push -= load
    dry = max(p[FSM] + p[LF] * abs(load) + periodic(p, WAVE, a), 0.0)
    if p[ANGLE_TABLE] > 0.0:
        push -= looked_up(table(p, ANGLE_TABLE), a)
    if p[FRICTION_TABLE] > 0.0:  # what there is at no speed is dry, the rest is added to it
        forwards = va > 0.0 or (va == 0.0 and push > 0.0)
        side = friction_tables(p, forwards)
        if side.shape[0] > 0:
            slowest = side[0, 1] if forwards else side[-1, 1]
            dry += slowest if forwards else -slowest
            push -= hot * (looked_up(side, va) - slowest)
    if p[BEND] > 0.0:
        state[BENT] = bristle_force(p, state[BENT], va, dry, h)
        va = kicked(va, p[JM], push - hot * state[BENT], hot * p[FVM], 0.0, 0.0, 0.0, h)
    elif p[SOFT] > 0.0:
        va = softly_kicked(p, va, p[JM], push, hot * p[FVM], hot * dry, h)
    else:
        va = kicked(va, p[JM], push, hot * p[FVM], hot * dry, hot * p[ST], p[ST_V], h)
    a += 0.5 * h * va
    if flexible:
        heavy, back = weight(p, b), 0.0
        push = load - heavy - warm * (p[AS_L] * abs(vb) + p[QU_L] * vb * abs(vb)) - p[JL] * swing
        if p[J2] > 0.0:
            back = p[K2] * (b - c) + p[D2] * (vb - vc)
            push -= back
            vc += h * (back / p[J2] - swing)
        dry = p[FS] + p[LF_L] * abs(load)
        if p[SOFT] > 0.0:
            vb = softly_kicked(p, vb, p[JL], push, warm * p[FV], warm * dry, h)
        else:
            vb = kicked(vb, p[JL], push, warm * p[FV], warm * dry, warm * p[ST_L], p[ST_VL], h)
        b += 0.5 * h * vb
        c += 0.5 * h * vc
        if p[JB] > 0.0:  # what moves motor and link pushes the base back
            moved = p[JM] * ((va - va_before) / h + swing) + p[JL] * ((vb - vb_before) / h + swing)
            held = p[KB] * state[BASE] + p[DB] * state[BASE_RATE]
            state[BASE_ACCELERATION] = -(moved + heavy + back + held) / p[JB]
            state[BASE_RATE] += h * state[BASE_ACCELERATION]
            state[BASE] += h * state[BASE_RATE]
    else:
        b, vb, c, vc = a, va, a, va
    state[0], state[1], state[2], state[3], state[4], state[5] = a, va, b, vb, c, vc


@compiled
def drive_torque(
    gains: Floats, kind: int, state: Floats, position: float, velocity: float, command: float, h: float
) -> float:
    """Torque, N m, that the drive asks for over the next `h` s; moves its part of `state` on.

    `position`, rad, and `velocity` of the motor are as its encoder reads them.
    `gains` (6,): position, velocity, integral gain, effort limit, inertia of the feedforward, rad/s of the smoothing.
    A position command goes through a critically damped filter, solved exactly, that gives its rate and acceleration.
    The integrator stops where the torque is limited.
    """
    limit = float(gains[3])
    if kind == EFFORT:
        return min(max(command, -limit), limit)
    ahead = 0.0
    wanted = command
    if kind == POSITION:
        omega = gains[5]
        error, rate = state[SMOOTH] - command, state[SMOOTH_RATE]
        slope, fall = rate + omega * error, math.exp(-omega * h)
        state[SMOOTH] = command + (error + slope * h) * fall
        state[SMOOTH_RATE] = (rate - omega * slope * h) * fall
        wanted = gains[0] * (state[SMOOTH] - position) + state[SMOOTH_RATE]
        ahead = gains[4] * (state[SMOOTH_RATE] - rate) / h
    error = wanted - velocity
    grown = state[INTEGRAL] + gains[2] * error * h
    torque = ahead + gains[1] * error + grown
    if torque > limit:
        state[INTEGRAL] = min(state[INTEGRAL], grown)
        return limit
    if torque < -limit:
        state[INTEGRAL] = max(state[INTEGRAL], grown)
        return -limit
    state[INTEGRAL] = grown
    return float(torque)


@compiled
def read_torque(p: Floats, state: Floats, torque: float, h: float) -> float:
    """What the driver says of a `torque`, N m, that holds for `h` s: its mean behind a low-pass, which moves on."""
    if p[LAG] <= 0.0:
        return torque
    off = state[SLOW] - torque
    state[SLOW] = torque + off * math.exp(-h / p[LAG])
    return float(torque + (off + torque - state[SLOW]) * p[LAG] / h)


@compiled
def sampled(
    p: Floats, gains: Floats, kind: int, state: Floats, command: float, disturbance: float, cycle: float,
    substeps: int, rows: Floats,
) -> None:  # fmt: skip
    """One sample of the joint: as many cycles of the drive, `cycle` s each, as `rows` (cycles, ROW), filled here.

    Between position commands the drive goes along a quadratic spline: steps would ring in the torque at their rate.
    """
    cycles = rows.shape[0]
    before, earlier = state[BEFORE], state[EARLIER]
    for i in range(cycles):
        asked = command
        if kind == POSITION:
            s = (i + 1.0) / cycles
            asked = before + 0.5 * ((1.0 - s) ** 2 * (earlier - before) + s * s * (command - before))
        rows[i, 0] = state[0] + periodic(p, MOTOR_READ, state[0])
        rows[i, 1] = state[1] * ratio_of(p, MOTOR_READ, state[0])
        rows[i, 2] = state[2] + periodic(p, LINK_READ, state[2])
        rows[i, 3] = state[3] * ratio_of(p, LINK_READ, state[2])
        torque = drive_torque(gains, kind, state, rows[i, 0], rows[i, 1], asked, cycle)
        rows[i, 4] = read_torque(p, state, torque, cycle) * (1.0 + p[GAIN] * state[TIME]) + p[SHIFT] * state[TIME]
        delivered = torque
        if p[LIMIT] > 0.0:
            delivered = min(max(torque, -p[LIMIT]), p[LIMIT])
        delivered /= 1.0 + p[IRON] * delivered * delivered + p[DROOP] * state[1] * state[1]
        warm = 1.0 + p[WARM] * state[TIME]
        for _ in range(substeps):
            stepped(p, state, delivered + disturbance, cycle / substeps, warm)
        state[TIME] += cycle
    state[BEFORE], state[EARLIER] = command, before


@compiled
def whole_run(
    p: Floats, gains: Floats, kind: int, state: Floats, commands: Floats, disturbances: Floats, cycle: float,
    substeps: int, cycles: int, rows: Floats,
) -> None:  # fmt: skip
    """`sampled` for every command (n,), filling `rows` (n cycles, ROW)."""
    for k in range(commands.size):
        part = rows[k * cycles : (k + 1) * cycles]
        sampled(p, gains, kind, state, commands[k], disturbances[k], cycle, substeps, part)


@compiled
def _rest_link(p: Floats, motor: float) -> float:
    """Where the link hangs still behind a motor at `motor`, rad: bisection on the balance of spring and weight."""
    if p[STIFFNESS] <= 0.0:
        return motor
    if abs(elastic_torque(p, deflection(p, motor, motor), 0.0) - weight(p, motor)) < 1e-12:
        return motor
    heaviest = GRAVITY * math.hypot(p[MX], p[MY]) + abs(p[PULL]) + abs(p[CABLE] * motor)
    heaviest += abs(p[CABLE_C]) + abs(p[CABLE_S])
    errors = 0.0
    for i in range(GEAR, GEAR + 3 * HARMONICS, 3):
        errors += abs(p[i])
    span = 2.0 * heaviest / p[STIFFNESS] + p[PLAY] + 2.0 * (p[ZONE] * p[ZONE_D] + errors) + 1e-9
    low, high = motor - span, motor + span
    for _ in range(60):
        link = 0.5 * (low + high)
        bent = deflection(p, motor, link)
        if elastic_torque(p, bent, 0.0) + uneven(p, motor) * bent > weight(p, link):
            low = link
        else:
            high = link
    return float(0.5 * (low + high))


def state_at_rest(p: Floats, motor: float, command: float) -> Floats:
    """The state (STATE,) of a joint that its drive holds still with the motor at `motor`, rad."""
    link = float(_rest_link(p, motor))
    state = np.zeros(STATE)
    state[0], state[2], state[4] = motor, link, link
    state[7] = float(deflection(p, motor, link))
    state[INTEGRAL] = float(weight(p, link)) + p[CONSTANT] + float(periodic(p, RIPPLE, motor))
    state[SLOW] = state[INTEGRAL]
    state[SMOOTH], state[BEFORE], state[EARLIER] = motor, command, command
    if p[KB] > 0.0:
        state[BASE] = -float(weight(p, link)) / p[KB]
    return state
