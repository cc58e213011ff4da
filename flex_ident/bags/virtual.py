"""The virtual joint's experiment as a bag, as a robot would have left it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flex_ident.bags.writing import write_joint_states
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_signals


def write_virtual_bag(
    path: Path, model: JointModel, experiment: Experiment | None = None, chain: MeasurementChain | None = None, *,
    seed: int = 0, storage: str = "mcap", compression: str = "", link: bool = True,
) -> None:  # fmt: skip
    """Write `/joint_states` (a held joint beside the one that moves), and `/link_joint_states` with a link encoder."""
    signals = {s.role: s for s in virtual_signals(model, experiment, chain, seed=seed, link=link)}
    motor, torque = signals["motor_position"], signals["motor_torque"]
    joint = model.joint or "joint"
    held = np.full_like(motor.values, 0.5)
    rate = np.gradient(motor.values, motor.time)
    more = {}
    if "link_position" in signals:
        position = signals["link_position"]
        more["/link_joint_states"] = (position.time, [joint], position.values[:, None])
    reference = signals["reference"]
    more["/chirp_exciter/reference"] = (reference.time, [joint], reference.values[:, None])
    write_joint_states(
        path, motor.time, ["held_joint", joint], np.column_stack((held, motor.values)),
        np.column_stack((np.zeros_like(held), rate)), np.column_stack((np.zeros_like(held), torque.values)),
        storage=storage, compression=compression, more=more,
    )  # fmt: skip
