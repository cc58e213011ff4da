"""Integrator two: Runge-Kutta of fourth order between events, which are located and landed on.

An event is a mass that comes to rest, or one that breaks loose: a mass is in one of three modes, sliding up, sliding
down, or held. With `tanh_speed` friction is smooth and there are none. Knows no effect with memory.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from plants.drive import clipped, commanded_torque, start_drive
from plants.laws import elastic_torque, gear_output, gravity_load, link_dry, motor_dry, motor_extras

MOST_EVENTS, HALVINGS = 40, 40


@njit(cache=True)
def pushes(p, y, t, u):
    """Torque on motor and link without their dry friction, and how large that can be, N m."""
    x, gear = gear_output(p, y[0])
    s = elastic_torque(p, x - y[2]) + p.damping * (gear * y[1] - y[3])
    warm = 1.0 + p.drift * t
    motor = u - gear * s - motor_extras(p, y[0], y[1], t) - warm * p.FVm * y[1]
    link = s - gravity_load(p, y[2]) - warm * p.FV * y[3]
    return motor, link, motor_dry(p, y[0], y[1], s, t), link_dry(p, t)


@njit(cache=True)
def slope(p, y, t, u, mode_m, mode_l):
    """Derivatives of motor position and speed, link position and speed."""
    motor, link, dry_m, dry_l = pushes(p, y, t, u)
    if p.tanh_speed > 0.0:
        motor -= dry_m * math.tanh(y[1] / p.tanh_speed)
        link -= dry_l * math.tanh(y[3] / p.tanh_speed)
        return np.array((y[1], motor / p.Jm, y[3], link / p.JL))
    am = 0.0 if mode_m == 0.0 else (motor - mode_m * dry_m) / p.Jm
    al = 0.0 if mode_l == 0.0 else (link - mode_l * dry_l) / p.JL
    return np.array((y[1] if mode_m != 0.0 else 0.0, am, y[3] if mode_l != 0.0 else 0.0, al))


@njit(cache=True)
def delivered_at(target, before, since, current_s):
    """Torque `since` the tick began, N m."""
    return target + (before - target) * math.exp(-since / current_s) if current_s > 0.0 else target


@njit(cache=True)
def advanced(p, y, t, since, h, target, before, current_s, mode_m, mode_l):
    """State after one step of Runge-Kutta's, the modes kept."""
    u0 = delivered_at(target, before, since, current_s)
    u1 = delivered_at(target, before, since + 0.5 * h, current_s)
    u2 = delivered_at(target, before, since + h, current_s)
    a = slope(p, y, t, u0, mode_m, mode_l)
    b = slope(p, y + 0.5 * h * a, t + 0.5 * h, u1, mode_m, mode_l)
    c = slope(p, y + 0.5 * h * b, t + 0.5 * h, u1, mode_m, mode_l)
    d = slope(p, y + h * c, t + h, u2, mode_m, mode_l)
    return y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)


@njit(cache=True)
def over(p, y, t, u, mode_m, mode_l):
    """Which masses left their mode: 1 the motor, 2 the link, 3 both."""
    motor, link, dry_m, dry_l = pushes(p, y, t, u)
    code = 0
    if (mode_m != 0.0 and y[1] * mode_m < 0.0) or (mode_m == 0.0 and abs(motor) > dry_m):
        code += 1
    if (mode_l != 0.0 and y[3] * mode_l < 0.0) or (mode_l == 0.0 and abs(link) > dry_l):
        code += 2
    return code


@njit(cache=True)
def next_mode(push, dry):
    """Mode of a mass at rest under a torque."""
    return 0.0 if abs(push) <= dry else math.copysign(1.0, push)


@njit(cache=True)
def run_events(p, d, reference, speed, acceleration, q0, sub):
    """The joint under its drive, `sub` steps a tick; returns what `run_stepping` does."""
    n = reference.size
    out = np.zeros((n, 6))
    full = d.tick_s / sub
    hold = gravity_load(p, q0)
    y = np.zeros(4)
    y[2] = q0
    y[0] = q0 + hold / p.K + (math.copysign(0.5 * p.gap, hold) if hold != 0.0 else 0.0)
    state = start_drive(d, y[0], hold)
    before = hold
    mode_m = mode_l = 0.0
    t = 0.0
    smooth = p.tanh_speed > 0.0
    for k in range(n):
        command = commanded_torque(d, state, y[0], reference[k], speed[k], acceleration[k])
        target = clipped(command, p.limit)
        out[k, 0], out[k, 1], out[k, 2], out[k, 5] = y[0], y[2], command, y[1]
        out[k, 4] = delivered_at(target, before, 0.0, d.current_s)
        lag = d.current_s * (1.0 - math.exp(-d.tick_s / d.current_s)) if d.current_s > 0.0 else 0.0
        out[k, 3] = target + (before - target) * lag / d.tick_s
        for j in range(sub):
            since, left, events = j * full, full, 0
            while left > 0.0:
                after = advanced(p, y, t, since, left, target, before, d.current_s, mode_m, mode_l)
                u = delivered_at(target, before, since + left, d.current_s)
                code = 0 if smooth or events > MOST_EVENTS else over(p, after, t + left, u, mode_m, mode_l)
                if code == 0:
                    y, t, left = after, t + left, 0.0
                    break
                low, high = 0.0, left  # the event lies between
                for _ in range(HALVINGS):
                    middle = 0.5 * (low + high)
                    trial = advanced(p, y, t, since, middle, target, before, d.current_s, mode_m, mode_l)
                    u = delivered_at(target, before, since + middle, d.current_s)
                    inside = over(p, trial, t + middle, u, mode_m, mode_l)
                    if inside == 0:
                        low = middle
                    else:
                        high, after, code = middle, trial, inside
                    if high - low < 1e-12:
                        break
                y = after
                u = delivered_at(target, before, since + high, d.current_s)
                if code != 2:
                    y[1] = 0.0
                if code != 1:
                    y[3] = 0.0
                motor, link, dry_m, dry_l = pushes(p, y, t + high, u)
                if code != 2:
                    mode_m = next_mode(motor, dry_m)
                if code != 1:
                    mode_l = next_mode(link, dry_l)
                t, since, left, events = t + high, since + high, left - high, events + 1
        before = delivered_at(target, before, d.tick_s, d.current_s)
        if not abs(y[1]) < 1e4:
            out[k:, :] = np.nan
            break
    return out
