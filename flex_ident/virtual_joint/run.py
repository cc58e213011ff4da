"""A whole experiment in one compiled loop."""

from __future__ import annotations

import numpy as np

from flex_ident.parameters import JointModel
from flex_ident.recording import Floats, Recording, Signal
from flex_ident.recording.alignment import aligned_recording
from flex_ident.virtual_joint.compiled import compiled
from flex_ident.virtual_joint.drive import INTERFACES, Drive, drive_for, drive_torque
from flex_ident.virtual_joint.experiment import Experiment
from flex_ident.virtual_joint.measurement import MeasurementChain, TrueMotion, measured_signals
from flex_ident.virtual_joint.physics import P, plant_values
from flex_ident.virtual_joint.plant import holding_torque, state_at_rest, stepped

SUBSTEPS = 10
WARM = int(P.WARMING)
LIMIT = int(P.DRIVE_LIMIT)


@compiled
def _run(
    p: Floats, state: Floats, gains: Floats, kind: int, integral: float, reference: Floats, disturbance: Floats,
    period: float, substeps: int, motor: Floats, link: Floats, velocity: Floats, torque: Floats,
) -> None:  # fmt: skip
    n = reference.size
    h = period / substeps
    for k in range(n):
        motor[k], velocity[k], link[k] = state[0], state[1], state[2]
        ahead = reference[k + 1] if k + 1 < n else reference[k]
        rate = (ahead - reference[k]) / period
        wanted, integral = drive_torque(gains, kind, reference[k], rate, state[0], state[1], integral, period)
        torque[k] = wanted
        delivered = wanted
        if p[LIMIT] > 0.0:
            delivered = min(max(wanted, -p[LIMIT]), p[LIMIT])
        delivered += disturbance[k]
        warm = 1.0 + p[WARM] * k * period
        for _ in range(substeps):
            stepped(p, state, delivered, h, warm)


def virtual_motion(
    model: JointModel, experiment: Experiment | None = None, *, drive: Drive | None = None,
    reference: Floats | None = None, disturbance: float = 0.0, seed: int = 0, substeps: int = SUBSTEPS,
) -> TrueMotion:  # fmt: skip
    """What the joint does when it is commanded the experiment, or `reference` (n,). `disturbance`, N m rms, acts too.

    The recorded torque is the commanded one, averaged over the sample around the encoders' instant.
    """
    experiment = experiment or Experiment()
    drive = drive or drive_for(model)
    wanted = experiment.reference() if reference is None else np.ascontiguousarray(reference, np.float64)
    p = plant_values(model)
    n = wanted.size
    push = np.random.default_rng([seed, 1]).normal(0.0, 1.0, n) * disturbance if disturbance else np.zeros(n)
    start = float(wanted[0]) if drive.interface == "position" else experiment.start
    integral = holding_torque(p, start)
    gains = np.array([drive.position_gain, drive.velocity_gain, drive.integral_gain, drive.effort_limit])
    motor, link, velocity, torque = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    kind = INTERFACES.index(drive.interface)
    period = 1.0 / experiment.sample_rate_hz
    _run(
        p, state_at_rest(p, start), gains, kind, integral, wanted, push, period, substeps, motor, link, velocity, torque
    )
    averaged = 0.5 * (torque + np.concatenate((torque[:1], torque[:-1])))
    return TrueMotion(experiment.sample_rate_hz, motor, link, velocity, averaged, wanted)


def virtual_signals(
    model: JointModel, experiment: Experiment | None = None, chain: MeasurementChain | None = None, *, seed: int = 0,
    drive: Drive | None = None, link: bool = True, reference: Floats | None = None,
) -> list[Signal]:  # fmt: skip
    """The signals that the joint's experiment leaves, as recorded. `link` False: no link encoder."""
    chain = chain or MeasurementChain()
    disturbance = 0.0
    if chain.torque_disturbance:
        quiet = virtual_motion(model, experiment, drive=drive, reference=reference)
        disturbance = chain.torque_disturbance * float(np.std(quiet.torque))
    motion = virtual_motion(model, experiment, drive=drive, reference=reference, disturbance=disturbance, seed=seed)
    return measured_signals(
        motion, chain, np.random.default_rng([seed, 2]), torque_delay=model.value("time_delay.delay"),
        link_skew=model.value("encoder_skew.skew"), link=link and not model.rigid,
    )  # fmt: skip


def virtual_recording(
    model: JointModel, experiment: Experiment | None = None, chain: MeasurementChain | None = None, *, seed: int = 0,
    drive: Drive | None = None, link: bool = True, reference: Floats | None = None,
) -> Recording:  # fmt: skip
    """The same signals on one clock, as the identification takes them."""
    signals = virtual_signals(model, experiment, chain, seed=seed, drive=drive, link=link, reference=reference)
    return aligned_recording(signals, joint=model.joint or "joint", notices=[], path="virtual", sha256="")
