"""Every command of docs/formats.md is run, on files made here."""

import json
import os
import re
import shlex
import sqlite3
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from filled_messages import filled
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from flex_ident.bags.known_types import KNOWN_TYPES
from flex_ident.virtual_joint import COBOT_JOINT, Experiment
from flex_ident.virtual_joint.run import virtual_signals

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
COMMANDS = [line for block in re.findall(r"```bash\n(.*?)```", PAGE, re.S) for line in block.strip().splitlines()]
EXTRAS = {"h5": "h5py", "parquet": "pyarrow", "so101_dataset": "pyarrow"}
"""What a command needs, by a word in it."""
START_NS = 1_700_000_000_000_000_000
Signals = dict[str, np.ndarray[Any, Any]]


@pytest.fixture(scope="module")
def swing() -> Signals:
    """A virtual joint's recording: t, q, ql, tau."""
    signals = {s.role: s for s in virtual_signals(COBOT_JOINT, Experiment(duration_s=12.0, sample_rate_hz=500.0))}
    motor = signals["motor_position"]
    return {
        "t": motor.time - motor.time[0], "q": motor.values, "tau": signals["motor_torque"].values,
        "ql": signals["link_position"].values,
    }  # fmt: skip


def write_bag(
    path: Path, swing: Signals, topics: dict[str, str], *, joint: int, names: list[str], own: str = ""
) -> None:
    """A bag without definitions whose topics are of these types; joint number `joint` swings."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for kind in topics.values():
        store.register(get_types_from_msg(KNOWN_TYPES.get(kind, (own,))[0], kind))
    header, stamp = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    state, zero = store.types["sensor_msgs/msg/JointState"], store.types["builtin_interfaces/msg/Duration"](0, 0)
    nothing = np.zeros(0)
    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in topics.items()}
        for i, t in enumerate(swing["t"]):
            now = START_NS + round(1e9 * t)
            head = header(stamp(*divmod(now, 1_000_000_000)), "")
            q, ql, tau = (np.where(np.arange(len(names)) == joint, swing[key][i], 0.0) for key in ("q", "ql", "tau"))
            for topic, kind in topics.items():
                given: dict[str, Any] = {"header": head}
                if kind.endswith("DynamicJointState"):
                    value, interfaces = store.types["control_msgs/msg/InterfaceValue"], ["position", "torque_sensor"]
                    values = [value(interfaces, np.array(own)) for own in zip(q, tau, strict=True)]
                    given |= {"joint_names": names, "interface_values": values}
                elif kind.endswith("ControllerState"):
                    point = store.types["trajectory_msgs/msg/JointTrajectoryPoint"](q, nothing, nothing, tau, zero)
                    given |= {"joint_names": names, "feedback": point}
                elif kind.endswith("FrankaRobotState"):
                    given |= {"measured_joint_state": state(head, names, ql, nothing, tau),
                              "measured_joint_motor_state": state(head, names, q, nothing, nothing)}  # fmt: skip
                else:
                    given = {"pos_estimate": q[0], "torque_estimate": tau[0]}
                content = store.serialize_cdr(filled(store, kind, **given), kind)
                writer.write(connections[topic], now, bytes(content))
    with sqlite3.connect(next(path.glob("*.db3"))) as database:
        database.execute("DELETE FROM message_definitions")
    database.close()


def write_foxglove(path: Path, swing: Signals) -> None:
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema("foxglove.JointStates", "jsonschema", b"{}")
        channel = writer.register_channel("/joint_states", "json", schema)
        for t, q, tau in zip(swing["t"], swing["q"], swing["tau"], strict=True):
            now = START_NS + round(1e9 * t)
            sec, nsec = divmod(now, 1_000_000_000)
            content = {"timestamp": {"sec": sec, "nsec": nsec}, "joints": [{"name": "a", "position": q, "effort": tau}]}
            writer.add_message(channel, now, json.dumps(content).encode(), now)
        writer.finish()


def write_tables(folder: Path, swing: Signals) -> None:
    t, q, tau = swing["t"], swing["q"], swing["tau"]
    two = {"q": np.column_stack((0.0 * q, q)), "tau": np.column_stack((0.0 * tau, tau))}
    for name, head, columns in (
        ("log.csv", "Time [ms],elbow_position [deg],elbow_torque", (1e3 * t, np.degrees(q), tau)),
        ("raw.csv", "millis,enc_a,enc_b,i_a,i_b", (1e3 * t, *two["q"].T, *two["tau"].T / 12.5)),
    ):  # fmt: skip
        np.savetxt(folder / name, np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.15g")
    six = [np.column_stack((*[0.0 * own] * 5, own)) for own in (q, tau)]
    np.savetxt(folder / "raw.txt", np.column_stack(six), header="six joints")
    scipy.io.savemat(folder / "log.mat", {"t": t, **two})
    (folder / "columns.yaml").write_text(re.findall(r"```yaml\n(.*?)```", PAGE, re.S)[0])
    try:
        import h5py

        with h5py.File(folder / "log.h5", "w") as file:
            file.update({"log/t": t, "log/q": two["q"], "log/tau": two["tau"]})
    except ImportError:
        pass
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        return
    pyarrow.parquet.write_table(pyarrow.table({"q": q, "tau": tau}), folder / "log.parquet")
    (folder / "so101_dataset" / "meta").mkdir(parents=True)
    features = {f"observation.{what}": {"names": ["elbow_flex.pos"]} for what in ("state", "effort")}
    information = {"codebase_version": "v3.0", "total_episodes": 2, "features": features}
    (folder / "so101_dataset" / "meta" / "info.json").write_text(json.dumps(information))
    (folder / "so101_dataset" / "data").mkdir()
    twice = {"timestamp": np.tile(t, 2), "episode_index": np.repeat([0, 1], t.size),
             "observation.state": np.degrees(np.tile(q, 2))[:, None].tolist(),
             "observation.effort": np.tile(tau, 2)[:, None].tolist()}  # fmt: skip
    pyarrow.parquet.write_table(pyarrow.table(twice), folder / "so101_dataset" / "data" / "file-000.parquet")


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory, swing: Signals) -> Path:
    """A folder with the files that the page speaks of, in which its commands are run in order."""
    folder = tmp_path_factory.mktemp("formats")
    arm = {"/dynamic_joint_states": "control_msgs/msg/DynamicJointState",
           "/controller_state": "control_msgs/msg/JointTrajectoryControllerState"}  # fmt: skip
    write_bag(folder / "arm_bag", swing, arm, joint=1, names=["joint_1", "joint_2"])
    franka = {"/franka_robot_state_broadcaster/robot_state": "franka_msgs/msg/FrankaRobotState"}
    write_bag(folder / "franka_bag", swing, franka, joint=3, names=[f"fr3_joint{i}" for i in range(1, 8)])
    drive = "float64 pos_estimate\nfloat64 torque_estimate\n"
    (folder / "Drive.msg").write_text(drive)
    write_bag(folder / "drive_bag", swing, {"/drive/status": "my_msgs/msg/Drive"}, joint=0, names=["drive"], own=drive)
    write_foxglove(folder / "foxglove.mcap", swing)
    write_tables(folder, swing)
    return folder


def test_there_are_commands() -> None:
    assert len(COMMANDS) >= 10


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_command(command: str, workspace: Path) -> None:
    for word, library in EXTRAS.items():
        if word in command:
            pytest.importorskip(library, reason=f"needs {library}")
    words = shlex.split(command)
    executable = Path(sysconfig.get_path("scripts")) / words[0]
    done = subprocess.run(
        [sys.executable, executable, *words[1:]], cwd=workspace, capture_output=True, text=True, timeout=300,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    if command.startswith("flex_ident import log.csv"):
        assert done.stdout.strip() in PAGE
    elif command.startswith("flex_ident check-bag"):
        assert "can be identified" in done.stdout
        assert "cannot be identified" not in done.stdout
