"""Plays a case: tunes the drive, finds an amplitude that suits the joint, moves it, and records.

`made` returns what a recording holds and the truth. The amplitude is lowered while the joint moves too far or too
fast, and raised while it hardly turns against its spring; the drive's gains are lowered while it is unstable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plants.cases import Case
from plants.drive import COMPUTED_TORQUE, CONTROLLERS, IMPEDANCE, Drive
from plants.events import run_events
from plants.excitation import excitation
from plants.hidden import Scales, samples_shifted, with_effect
from plants.joints import SIZES, drawn_joint
from plants.laws import Joint, gravity_load
from plants.measurement import Chain, Recorded, recorded
from plants.mujoco_plant import run_mujoco
from plants.stepping import run_stepping

STEPPING_HZ, EVENTS_HZ = 32000.0, 8000.0
ATTEMPTS = 8
FARTHEST = 2.0
"""Travel from the start position that stops a joint in torque mode or under impedance control, rad."""
FASTEST = 3.0
"""Speed over the joint's own that only an unstable drive or a violent one reaches."""
FEWEST_COUNTS = 15.0
"""Rms deflection in steps of the coarser encoder."""


class CaseError(Exception):
    """No amplitude and gain suit a case."""


@dataclass(frozen=True)
class Made:
    """A recording and its truth: parameters by name, and the range of those that a hidden effect makes ambiguous."""

    recorded: Recorded
    truth: dict[str, float]
    joint: Joint
    amplitude: float
    q0: float
    scales: Scales
    ticks: NDArray[np.float64]


@dataclass(frozen=True)
class Setup:
    """What stays while amplitude and gain are sought: the wave (n,) of unit amplitude at the ticks, the start."""

    case: Case
    wave: NDArray[np.float64]
    q0: float
    tick_s: float
    motor_step: float
    motor_phase: float
    current_s: float
    errors: NDArray[np.float64]
    """Factors on what the drive believes of the joint, (5,)."""


def start_position(joint: Joint, controller: str, rng: np.random.Generator) -> float:
    """Where the motion starts, rad; in torque mode near where gravity holds the joint."""
    if controller == "torque":
        return float(np.arctan2(-joint.MX, joint.MY) + rng.uniform(-0.4, 0.4))
    return float(rng.uniform(-1.2, 1.2))


def drive_of(joint: Joint, setup: Setup, gain: float) -> Drive:
    """The drive tuned for this joint; `gain` lowers all its gains."""
    kind = CONTROLLERS.index(setup.case.controller)
    omega, total, tick = 2.0 * np.pi * joint.locked_hz(), joint.Jm + joint.JL, setup.tick_s
    kv = gain * min(1.0 * omega * total, 0.25 * joint.Jm / tick)
    bandwidth = 0.3 * kv / total
    smoothing = min(0.6, 1.0 - np.exp(-tick * 12.0 * omega))
    kp, ki, damping = bandwidth, 0.4 * bandwidth, kv
    if kind != 0:
        kp, ki = kv * bandwidth, 0.3 * kv * bandwidth**2
    if kind == IMPEDANCE:
        kp = total * (0.12 * omega) ** 2
        damping = 0.6 * np.sqrt(kp * total) * min(1.0, gain)
    e = setup.errors
    known = {
        "inertia": e[0] * total, "viscous": e[1] * (joint.FVm + joint.FV), "dry": e[2] * (joint.FSm + joint.FS),
        "dry_speed": 0.05 * SIZES[setup.case.joint].speed, "mx": e[3] * joint.MX, "my": e[3] * joint.MY,
    }  # fmt: skip
    return Drive(
        kind, tick, kp, damping, ki, smoothing, setup.motor_step, setup.motor_phase, setup.current_s,
        **(known if kind in (COMPUTED_TORQUE, IMPEDANCE) else {}),
    )  # fmt: skip


def first_amplitude(joint: Joint, case: Case, drive: Drive) -> float:
    """Amplitude to begin with: of position, rad, or of torque, N m, in torque mode."""
    size = SIZES[case.joint]
    loud = 1.0 if case.loud else 0.45
    if case.controller not in ("torque", "impedance"):
        return loud * size.travel
    dry = joint.FSm + joint.FS
    torque = 1.6 * dry + loud * (0.4 * (joint.FVm + joint.FV) * size.speed + 0.8 * dry)
    torque += loud * 0.06 * (joint.Jm + joint.JL) * 2.0 * np.pi * joint.locked_hz() * size.speed
    return torque if case.controller == "torque" else torque / drive.kp


def moved(joint: Joint, setup: Setup, amplitude: float, gain: float) -> NDArray[np.float64]:
    """The motion at every tick, (n, 6), of one amplitude and gain."""
    base = gravity_load(joint, setup.q0) if setup.case.controller == "torque" else setup.q0
    reference = base + amplitude * setup.wave
    speed = np.gradient(reference) / setup.tick_s
    acceleration = np.gradient(speed) / setup.tick_s
    drive = drive_of(joint, setup, gain)
    friction = setup.case.friction
    if friction == "mujoco":
        return run_mujoco(joint, drive, reference, speed, acceleration, setup.q0)
    if friction == "coulomb_stepping" or joint.has_memory():
        sub = max(2, int(np.ceil(STEPPING_HZ * setup.tick_s)))
        return np.asarray(run_stepping(joint, drive, reference, speed, acceleration, setup.q0, sub))
    rate = EVENTS_HZ
    if joint.tanh_speed > 0.0:  # what friction's slope at rest makes stiff
        slope = max(joint.FSm / joint.Jm, joint.FS / joint.JL) / joint.tanh_speed
        rate = min(64000.0, max(rate, slope))
    sub = max(1, int(np.ceil(rate * setup.tick_s)))
    return np.asarray(run_events(joint, drive, reference, speed, acceleration, setup.q0, sub))


def scales_of(ticks: NDArray[np.float64], duration_s: float) -> Scales:
    """How large a motion is."""
    travel = ticks[:, 0] - np.mean(ticks[:, 0])
    deflection = ticks[:, 0] - ticks[:, 1]
    return Scales(
        float(np.std(ticks[:, 2])), float(np.std(ticks[:, 5])), float(np.std(deflection)), float(np.std(travel)),
        float(np.max(np.abs(ticks[:, 2]))), duration_s,
    )  # fmt: skip


def suited(
    joint: Joint, setup: Setup, amplitude: float, gain: float, coarse_step: float
) -> tuple[float, float, NDArray[np.float64]]:
    """Amplitude and gain that suit the joint, and the motion they give. Raises CaseError."""
    size = SIZES[setup.case.joint]
    soft = setup.case.controller in ("torque", "impedance")
    for _ in range(ATTEMPTS):
        ticks = moved(joint, setup, amplitude, gain)
        good = bool(np.all(np.isfinite(ticks)))
        fast = not good or np.max(np.abs(ticks[:, 5])) > FASTEST * size.speed
        far = not good or np.max(np.abs(ticks[:, 0] - setup.q0)) > FARTHEST
        if fast and not soft and setup.case.controller != "computed_torque":
            gain *= 0.6
        elif fast or far:
            amplitude *= 0.7
        elif np.std(ticks[:, 0] - ticks[:, 1]) < FEWEST_COUNTS * coarse_step:
            amplitude *= 1.5
        else:
            return amplitude, gain, ticks
    raise CaseError(f"{setup.case}: no amplitude and gain suit the joint.")


def made(case: Case, joint: Joint | None = None) -> Made:
    """The recording of a case, of the joint that it draws or of another one. Raises CaseError."""
    size = SIZES[case.joint]
    joint = drawn_joint(size, case.generator(0)) if joint is None else joint
    rng = case.generator(1)
    tick = 1.0 / (case.rate_hz * case.ratio)
    q0 = start_position(joint, case.controller, rng)
    motor_step = 2.0 * np.pi / 2.0 ** int(rng.integers(17 if size.gear > 1 else 19, 21)) / size.gear
    link_step = 2.0 * np.pi / 2.0 ** int(rng.integers(19, 21))
    phases = rng.uniform(0.0, 1.0, 2)
    free = joint.free_hz()
    high = min(2.0 * free, 0.28 * case.rate_hz)
    soft = case.controller in ("torque", "impedance")
    low = (0.04 if soft else 0.012) * joint.locked_hz()
    corner = 10.0 * high if soft else size.speed / (2.0 * np.pi * size.travel)
    if case.excitation == "prbs":
        corner = min(high, 2.0 * joint.locked_hz()) if soft else 2.0 * corner
    t = np.arange(round(case.duration_s / tick)) * tick
    wave = excitation(case.excitation, t, case.duration_s, low, high, corner, case.generator(2))
    if case.excitation == "rich" and soft:
        wave = np.clip(wave, -1.0, 1.0)
    current_s = 1.0 / (2.0 * np.pi * 800.0) if case.effort == "delivered" else 0.0
    setup = Setup(
        case, wave, q0, tick, motor_step, float(phases[0]), current_s, rng.uniform(0.85, 1.15, 5)
    )  # fmt: skip
    if case.friction == "tanh":
        share = float(np.exp(case.generator(5).uniform(np.log(1.5e-4), np.log(6e-4))))
        joint = joint._replace(tanh_speed=share * size.speed)
    noise = float(np.exp(rng.uniform(np.log(0.003), np.log(0.02))))
    amplitude = first_amplitude(joint, case, drive_of(joint, setup, 1.0))
    coarse = max(motor_step, link_step)
    amplitude, gain, ticks = suited(joint, setup, amplitude, 1.0, coarse)
    scales = scales_of(ticks, case.duration_s)
    delay = skew = 0.0
    truth = {key: getattr(joint, key) for key in ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "MX", "MY")}
    if case.effect:
        own = case.generator(3)
        clean = joint
        joint = with_effect(clean, case.effect, case.size, scales, own)
        if case.effect == "time_delay":
            delay = samples_shifted(case.size, own)
        elif case.effect == "encoder_skew":
            skew = samples_shifted(case.size, own) * float(own.choice((-1.0, 1.0)))
        else:
            amplitude, gain, ticks = suited(joint, setup, amplitude, gain, coarse)
        truth["JL_low"] = joint.JL
        truth["K_high"] = joint.K + joint.dahl_torque / joint.dahl_deflection
    chain = Chain(
        motor_step, link_step, float(phases[0]), float(phases[1]), case.effort, noise, case.lag_hz, delay, skew
    )  # fmt: skip
    held = recorded(ticks, case.ratio, tick, chain, case.generator(4))
    return Made(held, truth, joint, amplitude, q0, scales, ticks)
