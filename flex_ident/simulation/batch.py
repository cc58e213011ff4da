"""The link under several sets of terms in one pass: what sensitivities to all parameters cost least.

A step in which no link of the batch reverses or rests is taken for all of them side by side, by instructions that
work on several numbers at once; the others one by one, by the same `link_step` as a single simulation.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.compiled import compiled
from flex_ident.simulation.kernel import (
    HYS,
    RELAX,
    RUNAWAY,
    STRIBECK,
    ZONE,
    first_state,
    link_step,
    spring_torque,
)
from flex_ident.simulation.terms import Term

LANES = 8
"""Sets of terms that are simulated side by side."""
NEAR = 1e-2
"""Distance from the first link, rad, up to which another's sine and cosine follow from its, to the last digit."""
LANE_ROWS: dict[Term, int] = {
    Term.STIFFNESS: 4, Term.CUBIC_STIFFNESS: 5, Term.HALF_GAP: 6, Term.SPRING_DAMPING: 7, Term.LINK_INERTIA: 8,
    Term.LINK_VISCOUS: 9, Term.LINK_COULOMB: 10, Term.LINK_VISCOUS_ASYMMETRY: 11, Term.LINK_VISCOUS_QUADRATIC: 12,
    Term.LINK_LOAD_FRICTION: 13, Term.FRICTION_RATE: 14, Term.SECOND_STIFFNESS: 15, Term.SECOND_DAMPING: 16,
    Term.SECOND_INERTIA: 17, Term.GRAVITY_COS: 26, Term.GRAVITY_SIN: 27, Term.CABLE_STIFFNESS: 28,
    Term.CABLE_TORQUE: 29,
}  # fmt: skip
"""Terms that steps side by side know, and the row of a lane that holds each."""
STEPWISE = (
    Term.HYSTERESIS_TORQUE, Term.HYSTERESIS_DEFLECTION, Term.LINK_STRIBECK, Term.LINK_STRIBECK_VELOCITY,
    Term.SOFT_ZONE_SHARE, Term.SOFT_ZONE_DEFLECTION, Term.RELAXING_STIFFNESS, Term.RELAXATION_TIME,
)  # fmt: skip
"""Terms with which every step is taken by `link_step`."""
FIRST = (Term.INITIAL_DEFLECTION, Term.INITIAL_VELOCITY)
"""Terms of the state at the start, `first_state`."""
KNOWN = frozenset({int(t) for t in (*LANE_ROWS, *STEPWISE, *FIRST)} | {int(t) for t in Term if not t.moves_link})
"""All terms that a batch may hold. A term that is added is not among them: it is simulated by itself."""
_TERMS, _ROWS = np.array([int(t) for t in LANE_ROWS]), np.array(list(LANE_ROWS.values()))
_INERTIA, _SECOND = LANE_ROWS[Term.LINK_INERTIA], LANE_ROWS[Term.SECOND_INERTIA]


def side_by_side(terms: Floats) -> bool:
    """Whether `simulated_links` knows every term (len(Term),) that acts here."""
    for index in np.flatnonzero(terms):
        if int(index) in KNOWN:
            continue
        shaped = tuple(Term)[index].shape_of if index < len(Term) else None
        if shaped is None or terms[shaped] != 0.0:
            return False
    return True


Simulation = Callable[[Floats, Floats, Floats, float, Floats, Floats, Floats], None]


def _simulation(lanes: int) -> Simulation:
    """The simulation of that many sets of terms: their number is fixed, so that the compiler unrolls the loops."""

    @compiled
    def simulate(
        terms: Floats, base: Floats, base_rate: Floats, step: float, torque: Floats, position: Floats, velocity: Floats
    ) -> None:
        """Fill spring torque, position and velocity, (lanes, n), for `terms` (lanes, len(Term))."""
        n = torque.shape[1]
        # One array holds what a lane needs, row by row, so that the compiler sees that rows do not overlap.
        w = np.zeros(30 * lanes)
        hysteresis, relaxing = np.zeros(lanes), np.zeros(lanes)
        bound = np.empty(lanes)
        plain = True
        for j in range(lanes):
            p = terms[j]
            q, v = first_state(p, base[0], base_rate[0])
            bound[j] = RUNAWAY * (10.0 + abs(q))
            w[0 * lanes + j], w[1 * lanes + j], w[2 * lanes + j], w[3 * lanes + j] = q, v, q, v
            for i in range(_TERMS.size):
                w[_ROWS[i] * lanes + j] = p[_TERMS[i]]
            w[_INERTIA * lanes + j] = 1.0 / w[_INERTIA * lanes + j]
            second = w[_SECOND * lanes + j]
            w[_SECOND * lanes + j] = 1.0 / second if second != 0.0 else 0.0
            if second == 0.0:
                w[3 * lanes + j], w[15 * lanes + j], w[16 * lanes + j] = 0.0, 0.0, 0.0
            if p[HYS] != 0.0 or p[STRIBECK] != 0.0 or p[ZONE] != 0.0 or p[RELAX] != 0.0:
                plain = False
        last = 2 * (n - 1)
        for k in range(n):
            b0, r0 = base[2 * k], base_rate[2 * k]
            b1, b2 = base[min(2 * k + 1, last)], base[min(2 * k + 2, last)]
            r1, r2 = base_rate[min(2 * k + 1, last)], base_rate[min(2 * k + 2, last)]
            time = k * step
            turning = 0
            if plain:
                cosine, sine = math.cos(w[0]), math.sin(w[0])
                for j in range(lanes):
                    c, s = cosine, sine
                    apart = w[j] - w[0]
                    if (
                        not abs(apart) <= NEAR
                    ):  # true of NaN as well: a lane that runs away must not take others with it
                        c, s = math.cos(w[j]), math.sin(w[j])
                    elif j > 0:
                        square = apart * apart
                        sd = apart * (1.0 - square / 6.0 * (1.0 - square / 20.0))
                        cd = 1.0 - 0.5 * square * (1.0 - square / 12.0)
                        c, s = cosine * cd - sine * sd, sine * cd + cosine * sd
                    cable, pull = w[28 * lanes + j], w[29 * lanes + j]
                    w[18 * lanes + j] = w[26 * lanes + j] * c + w[27 * lanes + j] * s + pull + cable * w[j]
                    w[19 * lanes + j] = w[27 * lanes + j] * c - w[26 * lanes + j] * s + cable
                for j in range(lanes):
                    q, v, q2, v2 = w[j], w[lanes + j], w[2 * lanes + j], w[3 * lanes + j]
                    stiffness, cubic, gap, damping = (
                        w[4 * lanes + j],
                        w[5 * lanes + j],
                        w[6 * lanes + j],
                        w[7 * lanes + j],
                    )
                    inverse, coulomb, load = w[8 * lanes + j], w[10 * lanes + j], w[13 * lanes + j]
                    warm = 1.0 + w[14 * lanes + j] * time
                    viscous, one_way, quadratic = (
                        warm * w[9 * lanes + j], warm * w[11 * lanes + j], warm * w[12 * lanes + j]
                    )  # fmt: skip
                    k2, d2, inverse2 = w[15 * lanes + j], w[16 * lanes + j], w[17 * lanes + j]
                    weight, slope = w[18 * lanes + j], w[19 * lanes + j]
                    sign = 1.0 if v > 0.0 else -1.0
                    h = step
                    dq = dv = dq2 = dv2 = 0.0
                    kq = kv = kq2 = kv2 = 0.0
                    for stage in range(4):
                        share = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
                        times = 1.0 if stage == 0 or stage == 3 else 2.0
                        b = b0 if stage == 0 else (b2 if stage == 3 else b1)
                        r = r0 if stage == 0 else (r2 if stage == 3 else r1)
                        moved = share * kq
                        sv = v + share * kv
                        sq2, sv2 = q2 + share * kq2, v2 + share * kv2
                        d = b - q - moved
                        e = d - min(max(d, -gap), gap)
                        tau = stiffness * e + cubic * d * d * d + damping * (r - sv)
                        if stage == 0:
                            w[25 * lanes + j] = tau
                        dry = max(warm * (coulomb + load * abs(tau)), 0.0)
                        push = tau - viscous * sv - one_way * abs(sv) - quadratic * sv * abs(sv)
                        push -= weight * (1.0 - 0.5 * moved * moved) + slope * moved
                        pull = k2 * (sq2 - q - moved) + d2 * (sv2 - sv)
                        kq = sv
                        kv = (push + pull - sign * dry) * inverse
                        kq2, kv2 = sv2, -pull * inverse2
                        dq += times * kq
                        dv += times * kv
                        dq2 += times * kq2
                        dv2 += times * kv2
                    w[20 * lanes + j] = q + h * dq / 6.0
                    w[21 * lanes + j] = v + h * dv / 6.0
                    w[22 * lanes + j] = q2 + h * dq2 / 6.0
                    w[23 * lanes + j] = v2 + h * dv2 / 6.0
                    w[24 * lanes + j] = w[21 * lanes + j] * sign if v != 0.0 else -1.0
                for j in range(lanes):
                    torque[j, k], position[j, k], velocity[j, k] = w[25 * lanes + j], w[j], w[lanes + j]
                    if w[24 * lanes + j] < 0.0:
                        turning += 1
            else:
                for j in range(lanes):
                    torque[j, k] = spring_torque(terms[j], b0, b0 - w[j], r0 - w[lanes + j], hysteresis[j], relaxing[j])
                    position[j, k], velocity[j, k] = w[j], w[lanes + j]
            if k == n - 1:
                break
            if not plain or turning > 0:
                for j in range(lanes):
                    if plain and not w[24 * lanes + j] < 0.0:
                        continue
                    q, v, q2, v2, z, y = link_step(
                        terms[j], w[j], w[lanes + j], w[2 * lanes + j], w[3 * lanes + j], hysteresis[j], relaxing[j],
                        b0, b1, b2, r0, r1, r2, step, time, 0.0,
                    )  # fmt: skip
                    w[20 * lanes + j], w[21 * lanes + j] = q, v
                    w[22 * lanes + j], w[23 * lanes + j], hysteresis[j] = q2, v2, z
                    relaxing[j] = y
            for i in range(4 * lanes):
                w[i] = w[20 * lanes + i]
            for j in range(lanes):
                if not abs(w[j]) < bound[j]:  # it runs away, and what is not a number stays so
                    w[j] = np.nan

    return simulate


simulated_links = _simulation(LANES)
"""As `simulated_link`, for `terms` (`LANES`, len(Term)); fills spring torque, position, velocity, (`LANES`, n)."""
simulated_alone = _simulation(1)
"""The same for one set of terms, (1, len(Term)): two to four times as fast as `simulated_link`."""
