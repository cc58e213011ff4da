"""Joint states written as a rosbag2."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from flex_ident.errors import UsageError
from flex_ident.recording import Floats

JOINT_STATE = "sensor_msgs/msg/JointState"
STORAGE = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
EPOCH_NS = 1_700_000_000_000_000_000


def write_joint_states(
    path: Path, time: Floats, names: Sequence[str], position: Floats, velocity: Floats, effort: Floats, *,
    storage: str = "mcap", topic: str = "/joint_states",
    more: Mapping[str, tuple[Floats, Sequence[str], Floats]] | None = None,
) -> None:  # fmt: skip
    """Write a rosbag2 folder, replacing one that is there: `time` (n,), s; the others (n, joints), SI.

    `more` gives further JointState topics with time (m,), names and positions (m, joints) only. Raises UsageError.
    """
    if storage not in STORAGE:
        raise UsageError(f"storage is '{storage}': expected one of {', '.join(STORAGE)}.")
    if path.exists():
        if not (path / "metadata.yaml").exists():
            raise UsageError(f"{path} exists and is not a bag: it is not overwritten.")
        shutil.rmtree(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    store = get_typestore(Stores.ROS2_JAZZY)
    empty = np.zeros(0)
    with Writer(path, version=9, storage_plugin=STORAGE[storage]) as writer:
        channels = {topic: (time, list(names), position, velocity, effort)}
        for name, (at, joints, positions) in (more or {}).items():
            none = np.zeros((at.size, 0))
            channels[name] = (at, list(joints), positions, none, none)
        open_channels: dict[str, Any] = {
            name: writer.add_connection(name, JOINT_STATE, typestore=store) for name in channels
        }
        rows = sorted((float(at[0][k]), name, k) for name, at in channels.items() for k in range(at[0].size))
        types = store.types
        header, stamp, state = (
            types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"], types[JOINT_STATE],
        )  # fmt: skip
        for seconds, name, k in rows:
            _, joints, q, v, f = channels[name]
            ns = EPOCH_NS + round(seconds * 1e9)
            message = state(
                header=header(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id=""), name=joints,
                position=np.ascontiguousarray(q[k]) if q.size else empty,
                velocity=np.ascontiguousarray(v[k]) if v.size else empty,
                effort=np.ascontiguousarray(f[k]) if f.size else empty,
            )  # fmt: skip
            writer.write(open_channels[name], ns, store.serialize_cdr(message, JOINT_STATE))
