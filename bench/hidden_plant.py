"""A two-mass joint in closed loop with any effect hidden in it: the truth of `confusion.py`.

Nothing is shared with `flex_ident.simulation`: forward dynamics under a position and velocity controller (the
estimator runs the link from the recorded motor position), semi-implicit Euler at 200 steps a sample (whose torque acts
half a step early), friction by projection, hysteresis as four slipping springs in parallel (the estimator knows Dahl's
law), presliding friction as a bristle that is damped too, a base that feels the joint one step late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from hidden_effects import Scales
from numba import njit

from flex_ident.recording import Recording
from flex_ident.virtual_joint import JOINTS, Experiment

GRAVITY = 9.81
STEPS = 200
NAMES = (
    "Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "MX", "MY", "offset", "stribeck", "stribeck_velocity", "asymmetry",
    "quadratic", "load", "drift", "cubic", "gap", "slip_torque", "slip_deflection", "damping", "ripple",
    "ripple_cycles", "ripple_phase", "kinematic", "kinematic_cycles", "kinematic_phase", "limit", "second_inertia",
    "second_stiffness", "second_damping", "angle_jump", "angle_jump_at", "lugre", "lugre_bristle", "stribeck_link",
    "load_link", "quadratic_link", "asymmetry_link", "zone", "zone_deflection", "encoder",
    "encoder_cycles", "encoder_phase", "branch", "branch_time", "uneven", "uneven_cycles", "uneven_phase",
    "cable", "cable_torque", "iron", "droop", "bristle", "base_inertia", "base_stiffness", "base_damping",
)  # fmt: skip
INDEX = {name: i for i, name in enumerate(NAMES)}

KEYS = {
    "stribeck_friction.amplitude": "stribeck", "stribeck_friction.velocity": "stribeck_velocity",
    "torque_offset.offset": "offset", "viscous_asymmetry.coefficient": "asymmetry",
    "viscous_nonlinearity.coefficient": "quadratic", "load_dependent_friction.coefficient": "load",
    "friction_drift.rate": "drift", "nonlinear_stiffness.cubic": "cubic", "backlash.gap": "gap",
    "hysteresis.torque": "slip_torque", "hysteresis.deflection": "slip_deflection", "joint_damping.damping": "damping",
    "torque_ripple.amplitude": "ripple", "torque_ripple.cycles_per_turn": "ripple_cycles",
    "torque_ripple.phase": "ripple_phase", "kinematic_error.amplitude": "kinematic",
    "kinematic_error.cycles_per_turn": "kinematic_cycles", "kinematic_error.phase": "kinematic_phase",
    "saturation.limit": "limit", "second_mode.inertia": "second_inertia", "second_mode.stiffness": "second_stiffness",
    "second_mode.damping": "second_damping", "friction_jump.torque": "angle_jump",
    "friction_jump.angle": "angle_jump_at", "bristles.torque": "lugre", "bristles.deflection": "lugre_bristle",
    "motor_encoder_error.amplitude": "encoder", "motor_encoder_error.cycles_per_turn": "encoder_cycles",
    "viscoelastic_spring.stiffness": "branch", "viscoelastic_spring.time": "branch_time",
    "position_dependent_friction.amplitude": "uneven", "position_dependent_friction.cycles_per_turn": "uneven_cycles",
    "position_dependent_friction.phase": "uneven_phase", "cable_torque.stiffness": "cable",
    "cable_torque.torque": "cable_torque", "iron_saturation.loss": "iron", "torque_droop.loss": "droop",
    "presliding_friction.deflection": "bristle", "mount_mode.inertia": "base_inertia",
    "mount_mode.stiffness": "base_stiffness", "mount_mode.damping": "base_damping",
    "motor_encoder_error.phase": "encoder_phase", "soft_zone.share": "zone", "soft_zone.deflection": "zone_deflection",
}  # fmt: skip
"""The plant's name for each key of a hidden effect; `time_delay`, `encoder_skew`, `effort_lag` and `load_dead_time`
come after it."""


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
    bristle = branch = bent = base = base_rate = base_push = 0.0
    for k in range(n):
        read = a + p[41] * math.sin(p[42] * a + p[43])
        read_rate = va * (1.0 + p[41] * p[42] * math.cos(p[42] * a + p[43]))
        motor[k], link[k] = read, b
        rv = (ref[min(k + 1, n - 1)] - ref[k]) / ts
        e = kp * (ref[k] - read) + rv - read_rate
        integral += ki * e * ts
        u = kv * e + integral
        torque[k] = u
        if p[27] > 0.0:
            u = min(max(u, -p[27]), p[27])
        u /= 1.0 + p[51] * u * u
        warm = 1.0 + p[15] * k * ts
        for _ in range(STEPS):
            x = a + p[24] * math.sin(p[25] * a + p[26])
            gear = 1.0 + p[24] * p[25] * math.cos(p[25] * a + p[26])
            xv = va * gear
            d = x - b
            half = 0.5 * p[17]
            de = d - half if d > half else (d + half if d < -half else 0.0)
            if p[39] > 0.0:
                de *= 1.0 - p[39] * p[40] / math.sqrt(p[40] ** 2 + de**2)
            s = p[1] * de + p[16] * d * d * d + p[20] * (xv - vb)
            if p[18] > 0.0:
                for j in range(4):
                    width = p[19] * (0.4 + 0.6 * j)
                    slip[j] = min(max(slip[j] + (d - last_d) / width, -1.0), 1.0)
                    s += 0.25 * p[18] * slip[j]
            if p[44] > 0.0:
                branch += d - last_d - h / p[45] * branch
                s += p[44] * branch
            last_d = d
            smooth = p[9] + p[21] * math.sin(p[22] * a + p[23])
            smooth += warm * (p[3] * va + p[12] * abs(va) + p[13] * va * abs(va))
            if p[33] > 0.0:
                bristle += h * (va - abs(va) / p[34] * bristle)
                smooth += p[33] / p[34] * bristle
            dry = p[4] + p[14] * abs(s) + (p[10] * math.exp(-((va / p[11]) ** 2)) if p[10] != 0.0 else 0.0)
            if a > p[32]:
                dry += p[31]
            if p[46] != 0.0:
                dry += p[46] * math.sin(p[47] * a + p[48])
            dry *= warm
            drive = u / (1.0 + p[52] * va * va) + disturbance[k]
            if p[53] > 0.0:
                stiff = dry / p[53]
                rate = va - abs(va) / p[53] * bent
                bent += h * rate
                smooth += stiff * bent + 0.1 * math.sqrt(stiff * p[0]) * rate
                dry = 0.0
            brake = drive - gear * s - p[0] * base_push
            old = va
            free = va + h * (brake - smooth) / p[0]
            jump = h * dry / p[0]
            va = 0.0 if abs(free) <= jump else free - math.copysign(jump, free)
            brake -= p[0] * (va - old) / h
            push = s - warm * (p[5] * vb + p[38] * abs(vb) + p[37] * vb * abs(vb))
            own = GRAVITY * (p[7] * math.cos(b + base) + p[8] * math.sin(b + base)) + p[2] * base_push
            push -= own + p[49] * b + p[50]
            if p[28] > 0.0:
                back = p[29] * (b - c) + p[30] * (vb - vc)
                push -= back
                vc += h * back / p[28]
                c += h * vc
            free = vb + h * push / p[2]
            dry = p[6] + p[36] * abs(s) + (p[35] * math.exp(-((vb / p[11]) ** 2)) if p[35] != 0.0 else 0.0)
            jump = h * dry * warm / p[2]
            old = vb
            vb = 0.0 if abs(free) <= jump else free - math.copysign(jump, free)
            if p[54] > 0.0:
                brake += s - own - p[2] * (vb - old) / h
                base_push = (brake - drive - p[55] * base - p[56] * base_rate) / p[54]
                base_rate += h * base_push
                base += h * base_rate
            a += h * va
            b += h * vb
    return motor, link, torque


def _driven(
    values: dict[str, float], ref: np.ndarray, rate_hz: float, disturbance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    p = np.array([values.get(name, 0.0) for name in NAMES])
    omega = 2 * np.pi * 15.0
    kv = values["Jm"] * omega * 1.2
    return _run(p, ref, 1 / rate_hz, omega / 4, kv, kv * omega / 20, disturbance)


def scales_of(joint: str, experiment: Experiment) -> Scales:
    """How large torque, speed and deflection of a joint are along an experiment."""
    rate = experiment.sample_rate_hz
    values = {"stribeck_velocity": 1.0, "angle_jump_at": 1e9, **JOINTS[joint].parameters}
    ref = experiment.reference()
    motor, link, torque = _driven(values, ref, rate, np.zeros(ref.size))
    return Scales(
        float(np.std(torque)), float(np.std(np.gradient(motor)) * rate), float(np.std(motor - link)),
        float(np.ptp(motor)), float(np.max(np.abs(torque))), experiment.duration_s, 1.0 / rate,
    )  # fmt: skip


def low_passed(torque: np.ndarray, ts: float, time: float) -> np.ndarray:
    """A torque (n,), held over each sample, as a first-order low-pass shows it at the start of each."""
    slow = np.empty_like(torque)
    slow[0] = torque[0]
    for k in range(1, torque.size):
        slow[k] = torque[k - 1] + (slow[k - 1] - torque[k - 1]) * math.exp(-ts / time)
    return slow


def hidden_recording(
    joint: str, hidden: dict[str, float], experiment: Experiment, *, changed: dict[str, float] | None = None,
    seed: int = 0, noise: Noise | None = None, link: bool = True,
) -> Recording:  # fmt: skip
    """The joint with `hidden` terms (catalogue keys) and `changed` parameters, as recorded."""
    noise = noise or Noise()
    rng = np.random.default_rng(seed)
    rate, ref = experiment.sample_rate_hz, experiment.reference()
    values = {"stribeck_velocity": 1.0, "angle_jump_at": 1e9, **JOINTS[joint].parameters, **(changed or {})}
    values.update({KEYS[key]: value for key, value in hidden.items() if key in KEYS})
    size = float(np.std(_driven(values, ref, rate, np.zeros(ref.size))[2]))
    pushes = rng.normal(0.0, noise.disturbance * size, ref.size)
    motor, link_position, torque = _driven(values, ref, rate, pushes)
    held = 0.5 * (torque + np.concatenate((torque[:1], torque[:-1])))  # the mean around the instant of the encoder
    time = np.arange(ref.size) / rate
    load = values["K"] * np.abs(motor - link_position)
    late = hidden.get("time_delay.delay", 0.0) + hidden.get("load_dead_time.delay", 0.0) * load / max(load.mean(), 1e-9)
    if np.any(late):
        held = np.interp(time - late, time, held)
    if "effort_lag.time" in hidden:
        held = low_passed(torque, 1 / rate, hidden["effort_lag.time"])
    if "link_encoder_error.amplitude" in hidden:
        error, cycles, phase = (hidden[f"link_encoder_error.{k}"] for k in ("amplitude", "cycles_per_turn", "phase"))
        link_position = link_position + error * np.sin(cycles * link_position + phase)
    if "encoder_skew.skew" in hidden:
        link_position = np.interp(time - hidden["encoder_skew.skew"], time, link_position)
    held = held + rng.normal(0.0, noise.torque * size, ref.size)
    return Recording(
        joint=joint, sample_rate_hz=rate, motor_torque=held,
        motor_position=np.round(motor / noise.motor_step + rng.uniform()) * noise.motor_step,
        link_position=np.round(link_position / noise.link_step + rng.uniform()) * noise.link_step if link else None,
    )  # fmt: skip
