"""The joints of the known hard cases, played by the plants of `bench/plants` or by the small ones below.

Each is a pair of a recording and its truth. Flexible ones are a cobot's joint at 1 kHz under a P-PI drive at 4 kHz;
what is hidden in each is a change of the plant's own parameters.
"""

from __future__ import annotations

import math
import sys
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording import Recording

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from plants.cases import Case
from plants.excitation import excitation
from plants.experiment import Setup, drive_of, moved
from plants.laws import Joint
from plants.measurement import Chain, recorded, rounded
from plants.stepping import kicked

Truth = dict[str, float]
Floats = NDArray[np.float64]
COBOT = Joint(1.5, 12000.0, 2.2, 12.0, 6.0, 3.0, 1.0, 0.0, -8.0)
MOUNT = 44.0
HIDDEN: dict[str, dict[str, float]] = {
    "plain": {},
    "hysteresis": {"dahl_torque": 2.0, "dahl_deflection": 1e-3},
    "backlash": {"gap": 6e-4},
    "load_friction": {"load": 0.05},
    "stribeck": {"stribeck": 3.0, "stribeck_speed": 0.1},
    "lugre": {"bristle": 2e4, "stribeck": 3.0, "stribeck_speed": 0.05},
    "ripple_two": {
        "ripple": 5.0, "ripple_cycles": 200.0, "ripple_phase": 0.3,
        "ripple_2": 4.0, "ripple_2_cycles": 330.0, "ripple_2_phase": 1.1,
    },
    "mount_25hz": {
        "mount_inertia": MOUNT,
        "mount_stiffness": MOUNT * (2.0 * math.pi * 25.0) ** 2,
        "mount_damping": 0.02 * 2.0 * MOUNT * 2.0 * math.pi * 25.0,
    },
    "second_mode": {
        "JL": 1.9, "second_inertia": 0.3, "second_stiffness": 0.3 * (2.0 * math.pi * 22.0) ** 2,
        "second_damping": 0.06 * 0.3 * 2.0 * math.pi * 22.0,
    },
    "mujoco_friction": {"Jm": 2.5, "K": 9900.0, "FVm": 9.0, "FSm": 6.9, "FV": 3.5, "FS": 1.5, "MY": 0.0},
}  # fmt: skip
"""What differs from the plain cobot, by case."""
FLEXIBLE = ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "MX", "MY")
RATE_HZ, RATIO, DURATION_S, START = 1000.0, 4, 40.0, 0.6


@cache
def flexible_case(name: str, *, seed: int = 1) -> tuple[Recording, Truth]:
    """One of `HIDDEN` recorded: 17 bits on the motor behind a gear of 100, 20 on the link, torque noise of 1 %."""
    joint = COBOT._replace(**HIDDEN[name])
    friction = "mujoco" if name == "mujoco_friction" else "coulomb_stepping"
    case = Case(seed, 0, "cobot", "p_pi", "log_chirp", RATE_HZ, RATIO, True, friction, "command")
    tick = 1.0 / (RATE_HZ * RATIO)
    t = np.arange(round(DURATION_S / tick)) * tick
    wave = excitation("log_chirp", t, DURATION_S, 0.1, 40.0, 4.0, np.random.default_rng(seed))
    steps = 2.0 * math.pi / 2.0**17 / 100.0, 2.0 * math.pi / 2.0**20
    start = 0.0 if friction == "mujoco" else START
    setup = Setup(case, wave, start, tick, steps[0], 0.3, 0.0, np.ones(5))
    ticks = moved(joint, setup, 0.05 if friction == "mujoco" else 0.08, 1.0)
    assert np.isfinite(ticks).all()
    assert drive_of(joint, setup, 1.0).kind == 0
    held = recorded(ticks, RATIO, tick, Chain(*steps, 0.3, 0.6, "command", 0.01), np.random.default_rng(seed))
    recording = Recording(
        "elbow", RATE_HZ, held.motor_position, held.motor_torque, link_position=held.link_position
    )  # fmt: skip
    return recording, {key: float(getattr(joint, key)) for key in FLEXIBLE}


@cache
def rigid_gravity(seed: int = 0) -> tuple[Recording, Truth]:
    """A rigid shoulder, gravity most of the torque: slow smooth motion over 2 rad at 100 Hz, in closed form."""
    truth = {"J": 1.64, "FV": 1.82, "FS": 1.34, "MX": -1.065, "MY": 0.006}
    t = np.arange(6200) / 100.0
    lines = ((0.7, 2.0 * math.pi * 0.09), (0.3, 2.0 * math.pi * 0.23))
    q = -0.5 * math.pi + sum(a * np.sin(w * t) for a, w in lines)
    v = sum(a * w * np.cos(w * t) for a, w in lines)
    acceleration = sum(-a * w * w * np.sin(w * t) for a, w in lines)
    torque = truth["J"] * acceleration + truth["FV"] * v + truth["FS"] * np.sign(v)
    torque = torque + 9.81 * (truth["MX"] * np.cos(q) + truth["MY"] * np.sin(q))
    noise = 0.01 * float(np.std(torque)) * np.random.default_rng(seed).standard_normal(t.size)
    return Recording("shoulder", 100.0, rounded(q, 1e-5, 0.4), torque + noise), truth


@cache
def fast_loop(rate_hz: float = 5000.0, bandwidth_hz: float = 40.0) -> tuple[Recording, Truth]:
    """A rigid joint under a fast PD drive that differentiates its encoder: the rounding is in the torque, and no noise.

    Friction is set-valued (`plants.stepping.kicked`), the torque recorded is the command.
    """
    truth = {"J": 1.1, "FV": 8.5, "FS": 5.5}
    step = 4.66e-6
    t = np.arange(round(12.0 * rate_hz)) / rate_hz
    lines = ((1.2, 0.2, 0.3), (0.5, 0.6, 1.0), (0.2, 1.4, 2.0), (0.06, 2.8, 0.5))
    wanted: Floats = np.sum([a * np.sin(2.0 * math.pi * f * t + p) for a, f, p in lines], axis=0)
    omega = 2.0 * math.pi * bandwidth_hz
    kp, kd = truth["J"] * omega**2, 1.6 * truth["J"] * omega
    speed = np.gradient(wanted) * rate_hz
    position, torque = np.empty(t.size), np.empty(t.size)
    q, v, h = float(wanted[0]), float(speed[0]), 0.5 / rate_hz
    last = (math.floor(q / step) + 0.5) * step
    for k in range(t.size):
        read = (math.floor(q / step) + 0.5) * step
        u = kp * (wanted[k] - read) + kd * (speed[k] - (read - last) * rate_hz)
        last = read
        position[k], torque[k] = read, u
        for _ in range(2):
            before = v
            v = kicked(v, u, truth["FS"], truth["FV"], truth["J"], h)
            q += 0.5 * h * (before + v)
    kept = t > 0.5
    return Recording("joint", rate_hz, position[kept], torque[kept]), truth
