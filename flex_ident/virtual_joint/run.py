"""A whole experiment at once."""

from __future__ import annotations

import numpy as np

from flex_ident.parameters import JointModel
from flex_ident.recording import Floats, Recording, Signal
from flex_ident.recording.alignment import aligned_recording
from flex_ident.virtual_joint.drive import Drive, drive_cycles, drive_for
from flex_ident.virtual_joint.experiment import Experiment
from flex_ident.virtual_joint.joint import SUBSTEPS
from flex_ident.virtual_joint.measurement import MeasurementChain, measured_signals
from flex_ident.virtual_joint.motion import TrueMotion
from flex_ident.virtual_joint.physics import P, plant_values
from flex_ident.virtual_joint.plant import ROW, state_at_rest, whole_run


def virtual_motion(
    model: JointModel, experiment: Experiment | None = None, *, drive: Drive | None = None,
    reference: Floats | None = None, disturbance: float = 0.0, seed: int = 0, substeps: int = SUBSTEPS,
) -> TrueMotion:  # fmt: skip
    """What the joint does when it is commanded the experiment, or `reference` (n,). `disturbance`, N m rms, acts too.

    The reference is a position, velocity or effort as the drive's interface says; the motor starts at the first
    position, or at the experiment's `start`.
    """
    experiment = experiment or Experiment()
    drive = drive or drive_for(model)
    commands = experiment.reference() if reference is None else np.ascontiguousarray(reference, np.float64)
    n = commands.size
    pushes = np.random.default_rng([seed, 1]).normal(0.0, 1.0, n) * disturbance if disturbance else np.zeros(n)
    p = plant_values(model)
    state = state_at_rest(p, float(commands[0]) if drive.interface == "position" else experiment.start, commands[0])
    cycles = drive_cycles(experiment.sample_rate_hz)
    cycle_rate = cycles * experiment.sample_rate_hz
    rows = np.empty((n * cycles, ROW))
    whole_run(p, drive.gains, drive.kind, state, commands, pushes, 1.0 / cycle_rate, substeps, cycles, rows)
    return TrueMotion(experiment.sample_rate_hz, cycle_rate, rows, commands)


def virtual_signals(
    model: JointModel, experiment: Experiment | None = None, chain: MeasurementChain | None = None, *, seed: int = 0,
    drive: Drive | None = None, link: bool = True, reference: Floats | None = None,
) -> list[Signal]:  # fmt: skip
    """The signals that the joint's experiment leaves, as recorded. `link` False: no link encoder."""
    chain = chain or MeasurementChain()
    disturbance = 0.0
    if chain.torque_disturbance:
        quiet = virtual_motion(model, experiment, drive=drive, reference=reference)
        disturbance = chain.torque_disturbance * float(np.std(quiet.rows[:, 4]))
    motion = virtual_motion(model, experiment, drive=drive, reference=reference, disturbance=disturbance, seed=seed)
    plant = plant_values(model)
    return measured_signals(
        motion, chain, np.random.default_rng([seed, 2]), torque_delay=float(plant[P.TORQUE_DELAY]),
        link_skew=float(plant[P.LINK_SKEW]), link=link and not model.rigid,
    )  # fmt: skip


def virtual_recording(
    model: JointModel, experiment: Experiment | None = None, chain: MeasurementChain | None = None, *, seed: int = 0,
    drive: Drive | None = None, link: bool = True, reference: Floats | None = None,
) -> Recording:  # fmt: skip
    """The same signals on one clock, as the identification takes them."""
    signals = virtual_signals(model, experiment, chain, seed=seed, drive=drive, link=link, reference=reference)
    return aligned_recording(signals, joint=model.joint or "joint", notices=[], path="virtual", sha256="")
