"""Integrator one: drift, kick, drift, with dry friction solved exactly inside each kick.

Second order while a mass slides. Within a step the other forces are constant, so that the instant at which a speed
reaches zero, and whether the mass then stays or turns, are in closed form: friction is set-valued, and a mass that
sticks has a speed of exactly zero. LuGre's bristle and Dahl's hysteresis are updated by their exact exponentials.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from plants.drive import clipped, commanded_torque, start_drive
from plants.laws import elastic_torque, gear_output, gravity_load, link_dry, motor_dry, motor_extras

PASSES = 3
"""Times that a kick is repeated with the mean speeds it gave: forces that depend on speed are taken at mid step."""


@njit(cache=True)
def kicked(w, force, dry, viscous, inertia, h):
    """Speed after `h` under a constant force, viscous friction and set-valued dry friction, rad/s."""
    m = inertia + 0.5 * h * viscous
    if w == 0.0:
        if abs(force) <= dry:
            return 0.0
        return h * (force - math.copysign(dry, force)) / m
    push = force - viscous * w
    a = (push - math.copysign(dry, w)) / m
    after = w + a * h
    if after * w > 0.0:
        return after
    rest = h + w / a  # what is left of the step when the speed is zero
    if abs(force) <= dry:
        return 0.0
    return rest * (force - math.copysign(dry, force)) / m


@njit(cache=True)
def bristle_after(z, w, stiffness, dry, h):
    """LuGre's bristle deflection after `h` at constant speed, rad."""
    if w == 0.0 or dry <= 0.0:
        return z
    end = math.copysign(dry / stiffness, w)
    return end + (z - end) * math.exp(-abs(w) * stiffness / dry * h)


@njit(cache=True)
def run_stepping(p, d, reference, speed, acceleration, q0, sub):
    """The joint under its drive, `sub` steps a tick.

    Returns (n, 6), at each tick: motor and link position, rad, command, mean of the delivered torque over the tick
    that begins, delivered torque at that instant, N m, and motor speed, rad/s.
    """
    n = reference.size
    out = np.zeros((n, 6))
    h = d.tick_s / sub
    hold = gravity_load(p, q0)
    q = qc = q0
    qm = q0 + hold / p.K + (math.copysign(0.5 * p.gap, hold) if hold != 0.0 else 0.0)
    wm = w = wc = qb = wb = zd = z = 0.0
    x, _ = gear_output(p, qm)
    last = x - q
    state = start_drive(d, qm, hold)
    delivered = hold
    lag = math.exp(-h / d.current_s) if d.current_s > 0.0 else 0.0
    half_lag = math.exp(-0.5 * h / d.current_s) if d.current_s > 0.0 else 0.0
    t = 0.0
    for k in range(n):
        command = commanded_torque(d, state, qm, reference[k], speed[k], acceleration[k])
        target = clipped(command, p.limit)
        out[k, 0], out[k, 1], out[k, 2], out[k, 5] = qm, q, command, wm
        out[k, 4] = delivered if d.current_s > 0.0 else target
        total = 0.0
        for _ in range(sub):
            u = target + (delivered - target) * half_lag
            delivered = target + (delivered - target) * lag
            total += u
            qm += 0.5 * h * wm
            q += 0.5 * h * w
            qc += 0.5 * h * wc
            qb += 0.5 * h * wb
            x, gear = gear_output(p, qm)
            deflection = x - q
            static = elastic_torque(p, deflection)
            if p.dahl_torque > 0.0:
                step = deflection - last
                end = math.copysign(1.0, step)
                zd = end + (zd - end) * math.exp(-abs(step) / p.dahl_deflection)
                static += p.dahl_torque * zd
            last = deflection
            load = gravity_load(p, q + qb)
            warm = 1.0 + p.drift * (t + 0.5 * h)
            wm1, w1, wc1, wb1 = wm, w, wc, wb
            base = 0.0
            if p.bristle > 0.0:
                z = bristle_after(z, wm, p.bristle, motor_dry(p, qm, wm, static, t), 0.5 * h)
            for _ in range(PASSES):
                wmm, wlm, wcm, wbm = 0.5 * (wm + wm1), 0.5 * (w + w1), 0.5 * (wc + wc1), 0.5 * (wb + wb1)
                s = static + p.damping * (gear * wmm - wlm)
                smooth = motor_extras(p, qm, wmm, t)
                dry = motor_dry(p, qm, wmm, s, t)
                if p.bristle > 0.0:
                    rate = wmm - abs(wmm) * p.bristle * z / dry if dry > 0.0 else 0.0
                    smooth += p.bristle * z + p.bristle_damping * rate
                    dry = 0.0
                force = u - gear * s - smooth - p.Jm * base
                wm1 = kicked(wm, force, dry, warm * p.FVm, p.Jm, h)
                push = s - load - p.JL * base
                if p.second_inertia > 0.0:
                    back = p.second_stiffness * (q - qc) + p.second_damping * (wlm - wcm)
                    push -= back
                    wc1 = wc + h * (back / p.second_inertia - base)
                w1 = kicked(w, push, link_dry(p, t), warm * p.FV, p.JL, h)
                if p.mount_inertia > 0.0:
                    brakes = smooth + force - p.Jm * (wm1 - wm) / h + push - p.JL * (w1 - w) / h
                    base = (brakes - u - p.mount_stiffness * qb - p.mount_damping * wbm) / p.mount_inertia
                    wb1 = wb + h * base
            wm, w, wc, wb = wm1, w1, wc1, wb1
            if p.bristle > 0.0:
                z = bristle_after(z, wm, p.bristle, motor_dry(p, qm, wm, static, t), 0.5 * h)
            qm += 0.5 * h * wm
            q += 0.5 * h * w
            qc += 0.5 * h * wc
            qb += 0.5 * h * wb
            t += h
        out[k, 3] = total / sub
        if not abs(wm) < 1e4:
            out[k:, :] = np.nan
            break
    return out
