"""The drive: five discrete controllers that read an encoder once a tick and hold the torque until the next."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

P_PI, PID, COMPUTED_TORQUE, IMPEDANCE, TORQUE = range(5)
CONTROLLERS = ("p_pi", "pid", "computed_torque", "impedance", "torque")


class Drive(NamedTuple):
    """One controller's settings; `step` is the encoder's, rad, and `phase` where its counts lie, 0 to 1.

    `current_s` is the time constant of the current loop, s: the torque delivered follows the command by it.
    """

    kind: int
    tick_s: float
    kp: float
    kv: float
    ki: float
    smoothing: float
    """Share of a new speed in the filtered one, 0 to 1."""
    step: float
    phase: float
    current_s: float = 0.0
    inertia: float = 0.0
    viscous: float = 0.0
    dry: float = 0.0
    dry_speed: float = 1.0
    mx: float = 0.0
    my: float = 0.0


@njit(cache=True)
def read_encoder(d, qm):
    """Motor position as the encoder gives it, rad."""
    return (np.floor(qm / d.step + d.phase) - d.phase + 0.5) * d.step


@njit(cache=True)
def start_drive(d, qm, hold):
    """State of the controller at rest under the holding torque: last position, filtered speed, integral."""
    state = np.zeros(3)
    state[0] = read_encoder(d, qm)
    state[2] = hold
    return state


@njit(cache=True)
def commanded_torque(d, state, qm, reference, speed, acceleration):
    """Torque commanded at a tick, N m; `reference` is a torque in torque mode, else a position, rad."""
    if d.kind == TORQUE:
        return reference
    q = read_encoder(d, qm)
    state[1] += d.smoothing * ((q - state[0]) / d.tick_s - state[1])
    state[0] = q
    e = reference - q
    if d.kind == P_PI:
        ev = d.kp * e - state[1]
        state[2] += d.kv * d.ki * ev * d.tick_s
        return d.kv * ev + state[2]
    if d.kind == PID:
        state[2] += d.ki * e * d.tick_s
        return d.kp * e + d.kv * (speed - state[1]) + state[2]
    load = 9.81 * (d.mx * math.cos(reference) + d.my * math.sin(reference))
    if d.kind == IMPEDANCE:
        return load + d.kp * e - d.kv * state[1]
    forward = d.inertia * acceleration + d.viscous * speed + d.dry * math.tanh(speed / d.dry_speed)
    return load + forward + d.kp * e + d.kv * (speed - state[1])


@njit(cache=True)
def clipped(torque, limit):
    """The command within what the drive can deliver; a limit of zero is none."""
    return min(max(torque, -limit), limit) if limit > 0.0 else torque
