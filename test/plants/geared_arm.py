"""A geared arm by semi-implicit Euler at 20 kHz, dry friction by impulses: what its spring may do beside K.

An adversary found with such a plant what two masses on an ideal spring take for the link's friction.
"""

from __future__ import annotations

import numba
import numpy as np

from flex_ident.recording import Floats, Recording

TRUTH = {"Jm": 0.4, "K": 2e4, "JL": 4.0, "FVm": 12.0, "FSm": 8.0, "FV": 4.0, "FS": 2.5, "MX": 4.0, "MY": 9.0}
STEP_S = 5e-5
GRAVITY = 9.80665
RESOLUTION, NOISE = 2e-6, 0.005
"""Of the encoder, rad; of the effort, over its standard deviation."""
RELAXATION_S = 0.01


def recorded_arm(*, damping: float = 0.0, relaxing: float = 0.0, seed: int = 1) -> Recording:
    """A falling chirp of 30 s at 250 Hz, motor alone: `damping` across the spring, N m s/rad, and a part that relaxes,
    N m/rad."""
    time = np.arange(int(30.0 / STEP_S)) * STEP_S
    reference = _chirp(time, 0.5, 20.0, 0.15)
    values = np.array([*TRUTH.values(), damping, relaxing, RELAXATION_S])
    speed = np.gradient(reference, STEP_S)
    position, torque = _played(values, reference, speed, np.gradient(speed, STEP_S))
    every = round(1.0 / 250.0 / STEP_S)
    noise = NOISE * float(np.std(torque)) * np.random.default_rng(seed).standard_normal(torque[::every].size)
    rounded = np.round(position[::every] / RESOLUTION) * RESOLUTION
    return Recording("arm", 1.0 / (every * STEP_S), rounded, torque[::every] + noise)


def _chirp(time: Floats, low_hz: float, high_hz: float, amplitude: float) -> Floats:
    end = time[-1]
    rate = np.log(high_hz / low_hz) / end
    ramp = np.clip(time, 0.0, 1.0) * np.clip(end - time, 0.0, 1.0)
    phase = 2.0 * np.pi * low_hz / rate * (np.exp(rate * time) - 1.0)
    swing: Floats = amplitude * np.exp(-0.8 * rate * time) * np.sin(phase) * ramp**2 * (3.0 - 2.0 * ramp)
    return swing


@numba.njit(cache=False)  # type: ignore[untyped-decorator]
def _slowed(speed: float, by: float) -> float:
    return np.sign(speed) * max(abs(speed) - by, 0.0)


@numba.njit(cache=False)  # type: ignore[untyped-decorator]
def _played(values: Floats, reference: Floats, speed: Floats, acceleration: Floats) -> tuple[Floats, Floats]:
    jm, k, jl, fvm, fsm, fv, fs, mx, my, damping, relaxing, relaxation = values
    n = reference.size
    position, torque = np.zeros(n), np.zeros(n)
    qm = q = reference[0]
    vm = v = relaxed = command = 0.0
    for i in range(n):
        if i % 5 == 0:  # a drive at 4 kHz
            command = 12e3 * (reference[i] - qm) + 250.0 * (speed[i] - vm) + 3.0 * acceleration[i]
        relaxed += STEP_S * (vm - v - relaxed / relaxation)
        spring = k * (qm - q) + damping * (vm - v) + relaxing * relaxed
        vm = _slowed(vm + STEP_S * (command - spring - fvm * vm) / jm, STEP_S * fsm / jm)
        weight = GRAVITY * (mx * np.cos(q) + my * np.sin(q))
        v = _slowed(v + STEP_S * (spring - weight - fv * v) / jl, STEP_S * fs / jl)
        position[i], torque[i] = qm, command
        qm += STEP_S * vm
        q += STEP_S * v
    return position, torque
