"""A two-mass joint in closed loop with any effect hidden in it: the truth of `confusion.py`.

Nothing is shared with `flex_ident.simulation`: forward dynamics under a position and velocity controller (the
estimator runs the link from the recorded motor position), semi-implicit Euler at 20 steps a sample, friction by
projection, hysteresis as four slipping springs in parallel (the estimator knows Dahl's law).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from flex_ident.recording import Recording

GRAVITY = 9.81
STEPS = 20
NAMES = (
    "Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "MX", "MY", "offset", "stribeck", "stribeck_velocity", "asymmetry",
    "quadratic", "load", "drift", "cubic", "gap", "slip_torque", "slip_deflection", "damping", "ripple",
    "ripple_cycles", "ripple_phase", "kinematic", "kinematic_cycles", "kinematic_phase", "limit", "second_inertia",
    "second_stiffness", "second_damping", "angle_jump", "angle_jump_at", "lugre", "lugre_bristle", "stribeck_link",
    "load_link", "quadratic_link", "asymmetry_link",
)  # fmt: skip
INDEX = {name: i for i, name in enumerate(NAMES)}

JOINTS: dict[str, dict[str, float]] = {
    "paper": {"Jm": 174.8, "K": 20341.0, "JL": 47.45, "FVm": 235.9, "FSm": 41.4, "FV": 83.15, "FS": 8.46,
              "MX": -0.724, "MY": -53.4},
    "cobot": {"Jm": 1.0, "K": 1.0e4, "JL": 1.0, "FVm": 8.0, "FSm": 4.0, "FV": 2.0, "FS": 1.0, "MX": 0.5, "MY": 3.0},
    "series_elastic": {"Jm": 0.1, "K": 300.0, "JL": 0.1, "FVm": 0.5, "FSm": 0.3, "FV": 0.05, "FS": 0.05, "MX": 0.02,
                       "MY": 0.2},
}  # fmt: skip


@dataclass(frozen=True)
class Noise:
    """Encoder steps, rad; torque noise and disturbance, relative to the torque's rms."""

    motor_step: float = 1e-5
    link_step: float = 2.4e-5
    torque: float = 0.01
    disturbance: float = 0.005


@njit(cache=True)
def _run(p, ref, ts, kp, kv, ki, disturbance):
    n = ref.size
    motor, link, torque = np.empty(n), np.empty(n), np.empty(n)
    h = ts / STEPS
    a = ref[0]
    load0 = GRAVITY * (p[7] * math.cos(a) + p[8] * math.sin(a))
    b = a - load0 / p[1]
    va = vb = 0.0
    integral = load0
    slip = np.zeros(4)
    last_d = a - b
    c, vc = b, 0.0
    bristle = 0.0
    for k in range(n):
        motor[k], link[k] = a, b
        rv = (ref[min(k + 1, n - 1)] - ref[k]) / ts
        e = kp * (ref[k] - a) + rv - va
        integral += ki * e * ts
        u = kv * e + integral
        torque[k] = u
        if p[27] > 0.0:
            u = min(max(u, -p[27]), p[27])
        warm = 1.0 + p[15] * k * ts
        for _ in range(STEPS):
            x = a + p[24] * math.sin(p[25] * a + p[26])
            xv = va * (1.0 + p[24] * p[25] * math.cos(p[25] * a + p[26]))
            d = x - b
            half = 0.5 * p[17]
            de = d - half if d > half else (d + half if d < -half else 0.0)
            s = p[1] * de + p[16] * d * d * d + p[20] * (xv - vb)
            if p[18] > 0.0:
                for j in range(4):
                    width = p[19] * (0.4 + 0.6 * j)
                    slip[j] = min(max(slip[j] + (d - last_d) / width, -1.0), 1.0)
                    s += 0.25 * p[18] * slip[j]
            last_d = d
            smooth = p[9] + p[21] * math.sin(p[22] * a + p[23])
            smooth += warm * (p[3] * va + p[12] * abs(va) + p[13] * va * abs(va))
            if p[33] > 0.0:
                zmax = p[33] / (p[33] / p[34])
                zdot = va - abs(va) / zmax * bristle
                bristle += h * zdot
                smooth += p[33] / p[34] * bristle
            dry = p[4] + p[14] * abs(s) + (p[10] * math.exp(-((va / p[11]) ** 2)) if p[10] != 0.0 else 0.0)
            if a > p[32]:
                dry += p[31]
            dry *= warm
            free = va + h * (u + disturbance[k] - s - smooth) / p[0]
            jump = h * dry / p[0]
            va = 0.0 if abs(free) <= jump else free - math.copysign(jump, free)
            push = s - warm * (p[5] * vb + p[38] * abs(vb) + p[37] * vb * abs(vb))
            push -= GRAVITY * (p[7] * math.cos(b) + p[8] * math.sin(b))
            if p[28] > 0.0:
                back = p[29] * (b - c) + p[30] * (vb - vc)
                push -= back
                vc += h * back / p[28]
                c += h * vc
            free = vb + h * push / p[2]
            dry = p[6] + p[36] * abs(s) + (p[35] * math.exp(-((vb / p[11]) ** 2)) if p[35] != 0.0 else 0.0)
            jump = h * dry * warm / p[2]
            vb = 0.0 if abs(free) <= jump else free - math.copysign(jump, free)
            a += h * va
            b += h * vb
    return motor, link, torque


def reference(excitation: str, rate_hz: float, seconds: float) -> np.ndarray:
    """Commanded position (n,), rad: `chirp` (0.05 to 30 Hz, ±0.1 rad) or `rich` (slow sine, chirp, small chirp)."""
    if excitation == "chirp":
        return _chirp(0.1, seconds, rate_hz)
    slow = 0.5 * np.sin(2 * np.pi * 0.1 * np.arange(int(20 / 60 * seconds * rate_hz)) / rate_hz)
    return np.concatenate((slow, _chirp(0.1, 22 / 60 * seconds, rate_hz), _chirp(0.03, 18 / 60 * seconds, rate_hz)))


def _chirp(amplitude: float, seconds: float, rate_hz: float, start: float = 0.1, end: float = 30.0) -> np.ndarray:
    t = np.arange(int(seconds * rate_hz)) / rate_hz
    growth = math.log(end / start) / seconds
    phase = 2 * np.pi * start * np.expm1(growth * t) / growth
    omega = 2 * np.pi * start * np.exp(growth * t)
    fade = 0.5 - 0.5 * np.cos(np.pi * np.clip(np.minimum(t, t[-1] - t) / 1.0, 0.0, 1.0))
    # Constant amplitude up to 2 Hz, constant acceleration beyond 6: what a drive can follow.
    fall = np.minimum(1.0, 2 * np.pi * 2.0 / omega) * np.minimum(1.0, 2 * np.pi * 6.0 / omega)
    return amplitude * np.sin(phase) * fade * fall


def hidden_recording(
    joint: str, hidden: dict[str, float], *, excitation: str = "chirp", seed: int = 0, rate_hz: float = 1000.0,
    seconds: float = 60.0, noise: Noise | None = None, repeats: int = 1,
) -> Recording:  # fmt: skip
    """The joint with `hidden` terms, as recorded. `delay` and `skew`, s, shift the recorded torque and link."""
    noise = noise or Noise()
    rng = np.random.default_rng(seed)
    values = {"stribeck_velocity": 1.0, "angle_jump_at": 1e9, **JOINTS[joint], **hidden}
    p = np.array([values.get(name, 0.0) for name in NAMES])
    ref = np.tile(reference(excitation, rate_hz, seconds / repeats), repeats)
    omega = 2 * np.pi * 15.0
    kv = values["Jm"] * omega * 1.2
    quiet = _run(p, ref, 1 / rate_hz, omega / 4, kv, kv * omega / 20, np.zeros(ref.size))[2]
    size = float(np.std(quiet))
    drift = rng.normal(0.0, noise.disturbance * size, ref.size)
    motor, link, torque = _run(p, ref, 1 / rate_hz, omega / 4, kv, kv * omega / 20, drift)
    held = 0.5 * (torque + np.concatenate((torque[:1], torque[:-1])))  # the mean around the instant of the encoder
    time = np.arange(ref.size) / rate_hz
    if hidden.get("delay"):
        held = np.interp(time - hidden["delay"], time, held)
    if hidden.get("skew"):
        link = np.interp(time - hidden["skew"], time, link)
    held = held + rng.normal(0.0, noise.torque * size, ref.size)
    return Recording(
        joint=joint, sample_rate_hz=rate_hz, motor_torque=held,
        motor_position=np.round(motor / noise.motor_step + rng.uniform()) * noise.motor_step,
        link_position=np.round(link / noise.link_step + rng.uniform()) * noise.link_step,
    )  # fmt: skip
