"""The link under several sets of terms in one pass: what sensitivities to all parameters cost least.

A step in which no link of the batch reverses or rests is taken for all of them side by side, by instructions that
work on several numbers at once; the others one by one, by the same `link_step` as a single simulation.
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.recording import Floats
from flex_ident.simulation.compiled import compiled
from flex_ident.simulation.kernel import (
    D2,
    DAMP,
    FS,
    FV,
    FV_ASYM,
    FV_QUAD,
    GX,
    GY,
    HALF_GAP,
    HYS,
    JL,
    K2,
    K3,
    LOAD,
    RATE,
    RUNAWAY,
    STRIBECK,
    K,
    first_state,
    link_step,
    spring_torque,
)
from flex_ident.simulation.kernel import J2 as SECOND

LANES = 8
"""Sets of terms that are simulated side by side."""
NEAR = 1e-2
"""Distance from the first link, rad, up to which another's sine and cosine follow from its, to the last digit."""


@compiled
def simulated_links(
    terms: Floats, base: Floats, base_rate: Floats, step: float, torque: Floats, position: Floats, velocity: Floats
) -> None:
    """As `simulated_link`, for `terms` (`LANES`, len(Term)); fills spring torque, position, velocity, (`LANES`, n)."""
    n = torque.shape[1]
    # One array holds what a lane needs, row by row, so that the compiler sees that rows do not overlap.
    w = np.zeros(30 * LANES)
    hysteresis = np.zeros(LANES)
    bound = np.empty(LANES)
    plain = True
    for j in range(LANES):
        p = terms[j]
        q, v = first_state(p, base[0], base_rate[0])
        bound[j] = RUNAWAY * (10.0 + abs(q))
        w[0 * LANES + j], w[1 * LANES + j], w[2 * LANES + j], w[3 * LANES + j] = q, v, q, v
        w[4 * LANES + j], w[5 * LANES + j], w[6 * LANES + j] = p[K], p[K3], p[HALF_GAP]
        w[7 * LANES + j], w[8 * LANES + j], w[9 * LANES + j] = p[DAMP], 1.0 / p[JL], p[FV]
        w[10 * LANES + j], w[11 * LANES + j], w[12 * LANES + j] = p[FS], p[FV_ASYM], p[FV_QUAD]
        w[13 * LANES + j], w[14 * LANES + j], w[15 * LANES + j] = p[LOAD], p[RATE], p[K2]
        w[26 * LANES + j], w[27 * LANES + j] = p[GX], p[GY]
        w[16 * LANES + j], w[17 * LANES + j] = p[D2], 1.0 / p[SECOND] if p[SECOND] > 0.0 else 0.0
        if p[SECOND] <= 0.0:
            w[3 * LANES + j], w[15 * LANES + j], w[16 * LANES + j] = 0.0, 0.0, 0.0
        if p[HYS] != 0.0 or p[STRIBECK] != 0.0:
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
            for j in range(LANES):
                c, s = cosine, sine
                apart = w[j] - w[0]
                if not abs(apart) <= NEAR:  # true of NaN as well: a lane that runs away must not take others with it
                    c, s = math.cos(w[j]), math.sin(w[j])
                elif j > 0:
                    square = apart * apart
                    sd = apart * (1.0 - square / 6.0 * (1.0 - square / 20.0))
                    cd = 1.0 - 0.5 * square * (1.0 - square / 12.0)
                    c, s = cosine * cd - sine * sd, sine * cd + cosine * sd
                w[18 * LANES + j] = w[26 * LANES + j] * c + w[27 * LANES + j] * s
                w[19 * LANES + j] = w[27 * LANES + j] * c - w[26 * LANES + j] * s
            for j in range(LANES):
                q, v, q2, v2 = w[j], w[LANES + j], w[2 * LANES + j], w[3 * LANES + j]
                stiffness, cubic, gap, damping = w[4 * LANES + j], w[5 * LANES + j], w[6 * LANES + j], w[7 * LANES + j]
                inverse, coulomb, load = w[8 * LANES + j], w[10 * LANES + j], w[13 * LANES + j]
                warm = 1.0 + w[14 * LANES + j] * time
                viscous, one_way, quadratic = (
                    warm * w[9 * LANES + j], warm * w[11 * LANES + j], warm * w[12 * LANES + j]
                )  # fmt: skip
                k2, d2, inverse2 = w[15 * LANES + j], w[16 * LANES + j], w[17 * LANES + j]
                weight, slope = w[18 * LANES + j], w[19 * LANES + j]
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
                        w[25 * LANES + j] = tau
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
                w[20 * LANES + j] = q + h * dq / 6.0
                w[21 * LANES + j] = v + h * dv / 6.0
                w[22 * LANES + j] = q2 + h * dq2 / 6.0
                w[23 * LANES + j] = v2 + h * dv2 / 6.0
                w[24 * LANES + j] = w[21 * LANES + j] * sign if v != 0.0 else -1.0
            for j in range(LANES):
                torque[j, k], position[j, k], velocity[j, k] = w[25 * LANES + j], w[j], w[LANES + j]
                if w[24 * LANES + j] < 0.0:
                    turning += 1
        else:
            for j in range(LANES):
                torque[j, k] = spring_torque(terms[j], b0 - w[j], r0 - w[LANES + j], hysteresis[j])
                position[j, k], velocity[j, k] = w[j], w[LANES + j]
        if k == n - 1:
            break
        if not plain or turning > 0:
            for j in range(LANES):
                if plain and not w[24 * LANES + j] < 0.0:
                    continue
                q, v, q2, v2, z = link_step(
                    terms[j], w[j], w[LANES + j], w[2 * LANES + j], w[3 * LANES + j], hysteresis[j],
                    b0, b1, b2, r0, r1, r2, step, time,
                )  # fmt: skip
                w[20 * LANES + j], w[21 * LANES + j] = q, v
                w[22 * LANES + j], w[23 * LANES + j], hysteresis[j] = q2, v2, z
        for i in range(4 * LANES):
            w[i] = w[20 * LANES + i]
        for j in range(LANES):
            if not abs(w[j]) < bound[j]:  # it runs away, and what is not a number stays so
                w[j] = np.nan
