"""A joint in MuJoCo: truth from somebody else's physics.

Motor and link are two hinges about one axis, coupled by a fixed tendon that is the spring; dry friction is MuJoCo's
`frictionloss` (a constraint), viscous friction its joint damping, gravity a mass off the axis, backlash the range of
the tendon's rest length. Only drive and measurement chain are the virtual joint's.

MuJoCo's integrator is of first order: positions lead by half its step (0.05 ms at 1 kHz: a torque delay), and Jm looks
larger by FVm times half its step.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from flex_ident.parameters import JointModel
from flex_ident.recording import Recording
from flex_ident.recording.alignment import aligned_recording
from flex_ident.virtual_joint import Experiment, MeasurementChain, TrueMotion, drive_for
from flex_ident.virtual_joint.drive import drive_cycles
from flex_ident.virtual_joint.measurement import measured_signals
from flex_ident.virtual_joint.plant import ROW, SMOOTH, STATE, drive_torque

GRAVITY = 9.81
SUBSTEPS = 5
EFFECTS = (
    "backlash.gap", "joint_damping.damping", "torque_offset.offset", "gravity.MX", "gravity.MY", "saturation.limit",
    "second_mode.inertia", "second_mode.stiffness", "second_mode.damping", "time_delay.delay", "encoder_skew.skew",
)  # fmt: skip


def mujoco_model(model: JointModel, timestep: float) -> mujoco.MjModel:
    """The joint as MuJoCo has it. Axis y: the weight of a mass at (x, z) is -m x g cos q - m z g sin q (eq. 7)."""
    mx = model.value("MX") + model.value("gravity.MX")
    my = model.value("MY") + model.value("gravity.MY")
    moment, inertia = mx**2 + my**2, model.value("JL")
    mass = 4.0 * moment / inertia if moment else 1.0
    own = inertia - moment / mass
    half = 0.5 * model.value("backlash.gap")
    second = ""
    tendons = _tendon("spring", "motor", "link", model.value("K"), model.value("joint_damping.damping"), half)
    if model.value("second_mode.inertia"):
        second = _body("second", model.value("second_mode.inertia"), 1.0, (0.0, 0.0), 0.0, 0.0)
        tendons += _tendon(
            "tip", "link", "second", model.value("second_mode.stiffness"), model.value("second_mode.damping"), 0.0
        )
    motor = _body("motor", model.value("Jm"), 1.0, (0.0, 0.0), model.value("FVm"), model.value("FSm"))
    link = _body("link", own, mass, (-mx / mass, -my / mass), model.value("FV"), model.value("FS"))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{timestep}" gravity="0 0 -{GRAVITY}" integrator="implicitfast" tolerance="1e-12">'
        f'<flag contact="disable"/></option><worldbody>{motor}{link}{second}</worldbody>'
        f"<tendon>{tendons}</tendon></mujoco>"
    )


def _body(name: str, inertia: float, mass: float, centre: tuple[float, float], viscous: float, dry: float) -> str:
    return (
        f'<body><inertial pos="{centre[0]} 0 {centre[1]}" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>'
        f'<joint name="{name}" type="hinge" axis="0 1 0" damping="{viscous}" frictionloss="{dry}" '
        f'solreffriction="0.0005 1" solimpfriction="0.999 0.9999 0.001"/></body>'
    )


def _tendon(name: str, first: str, other: str, stiffness: float, damping: float, half: float) -> str:
    return (
        f'<fixed name="{name}" stiffness="{stiffness}" damping="{damping}" springlength="{-half} {half}">'
        f'<joint joint="{first}" coef="1"/><joint joint="{other}" coef="-1"/></fixed>'
    )


def mujoco_motion(model: JointModel, experiment: Experiment, *, disturbance: float = 0.0, seed: int = 0) -> TrueMotion:
    """The joint under the virtual joint's drive, its torque held over each cycle."""
    unknown = [f"{e}.{p}" for e, ps in model.effects.items() for p in ps if f"{e}.{p}" not in EFFECTS]
    assert not unknown, f"the MuJoCo joint has no {unknown}"
    reference = experiment.reference()
    cycles = drive_cycles(experiment.sample_rate_hz)
    cycle = 1.0 / (cycles * experiment.sample_rate_hz)
    physics = mujoco_model(model, cycle / SUBSTEPS)
    data = mujoco.MjData(physics)
    data.qpos[:] = reference[0]
    mujoco.mj_forward(physics, data)
    weight = float(data.qfrc_bias[1])
    data.qpos[1:] -= weight / model.value("K") + math.copysign(0.5 * model.value("backlash.gap"), weight)
    drive = drive_for(model)
    gains, kind = drive.gains, drive.kind
    memory = np.zeros(STATE)
    offset = model.value("offset") + model.value("torque_offset.offset")
    memory[8], memory[SMOOTH] = weight + offset, reference[0]
    limit = model.value("saturation.limit") or math.inf
    pushes = np.random.default_rng([seed, 1]).normal(0.0, 1.0, reference.size) * disturbance
    rows = np.empty((reference.size * cycles, ROW))
    earlier = before = reference[0]
    for k, command in enumerate(reference):
        for i in range(cycles):
            memory[0], memory[1] = data.qpos[0], data.qvel[0]
            s = (i + 1.0) / cycles
            asked = before + 0.5 * ((1.0 - s) ** 2 * (earlier - before) + s * s * (command - before))
            torque = drive_torque(gains, kind, memory, memory[0], memory[1], asked, cycle)
            rows[k * cycles + i] = (data.qpos[0], data.qvel[0], data.qpos[1], data.qvel[1], torque)
            data.qfrc_applied[0] = min(max(torque, -limit), limit) + pushes[k] - offset
            mujoco.mj_step(physics, data, SUBSTEPS)
        earlier, before = before, command
    return TrueMotion(experiment.sample_rate_hz, 1.0 / cycle, rows, reference)


def mujoco_recording(
    model: JointModel, experiment: Experiment | None = None, chain: MeasurementChain | None = None, *, seed: int = 0,
    link: bool = True,
) -> Recording:  # fmt: skip
    """The MuJoCo joint's experiment through the measurement chain."""
    chain = chain or MeasurementChain()
    experiment = experiment or Experiment()
    disturbance = 0.0
    if chain.torque_disturbance:
        disturbance = chain.torque_disturbance * float(np.std(mujoco_motion(model, experiment).rows[:, 4]))
    motion = mujoco_motion(model, experiment, disturbance=disturbance, seed=seed)
    signals = measured_signals(
        motion, chain, np.random.default_rng([seed, 2]), torque_delay=model.value("time_delay.delay"),
        link_skew=model.value("encoder_skew.skew"), link=link,
    )  # fmt: skip
    return aligned_recording(signals, joint=model.joint or "joint", path="mujoco")
