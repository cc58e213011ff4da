"""The virtual joint's recordings with another effort than the motor's torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flex_ident.parameters import JointModel
from flex_ident.recording import Recording
from flex_ident.virtual_joint import Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_motion, virtual_recording

GRAVITY = 9.81
NOISE = 0.01
"""Of the effort's standard deviation."""


def kind_recording(
    model: JointModel,
    kind: str,
    experiment: Experiment,
    *,
    bits: int = 17,
    link: bool = True,
    seed: int = 1,
    removed: float = 1.0,
) -> Recording:
    """`motor`, `joint_sensor` (torque of the spring), `gravity_compensated`, `friction_compensated` (by a model that is
    20 % too large), `current` (0.1 A a N m) or `unsigned`, each with its noise; `sensor_less_gravity` is a joint
    sensor's, `less_both` the motor's without gravity and friction. `removed`: share of gravity that the controller
    takes off."""
    chain = MeasurementChain.with_bits(bits, bits, torque_noise=0.0, jitter=0.0, lost=0.0)
    recording = virtual_recording(model, experiment, chain, seed=seed, link=link)
    torque = recording.motor_torque.copy()
    if kind in ("joint_sensor", "sensor_less_gravity"):
        motion = virtual_motion(model, experiment, seed=seed)
        instants = recording.start_time_s + recording.time
        deflection = np.interp(instants, motion.time, motion.motor_position - motion.link_position)
        torque = model.value("K") * deflection
    if kind in ("gravity_compensated", "sensor_less_gravity", "less_both"):
        position = recording.motor_position
        torque -= removed * GRAVITY * (model.value("MX") * np.cos(position) + model.value("MY") * np.sin(position))
    if kind in ("friction_compensated", "less_both"):
        speed = np.gradient(recording.motor_position, recording.time)
        torque -= 1.2 * (model.value("FVm") * speed + model.value("FSm") * np.tanh(speed / 0.01))
    elif kind == "current":
        torque *= 0.1
    elif kind == "unsigned":
        torque = np.abs(torque)
    noise = NOISE * float(np.std(torque)) * np.random.default_rng([seed, 7]).standard_normal(torque.size)
    return replace(recording, motor_torque=torque + noise)
