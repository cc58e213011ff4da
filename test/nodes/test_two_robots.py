"""Two robots on one network, told apart by their namespaces alone: each exciter moves its own, in its own limits."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy", reason="needs rclpy")
from rclpy.utilities import get_rmw_implementation_identifier
from rig import CHIRP, JOINT, Rig, rig
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import JointState

from flex_ident.nodes.bag_file import RUN_FILE
from flex_ident.nodes.transports import without_shared_memory

pytestmark = pytest.mark.ros
SIDES = {"left": (0.1, 0.05), "right": (-0.3, 0.2)}
"""Where each robot's joint stands, rad, and how far it is to swing."""


def robot_and_exciter(made: Rig, side: str) -> None:
    """Both in a namespace; nothing else tells them from those of the other side."""
    position, amplitude = SIDES[side]
    folder = made.folder / side
    folder.mkdir()
    robot = {
        "namespace": f"/{side}", "positions": [0.5, position], "limit": 0.2 if side == "left" else 1.0,
        "truth": str(folder / "truth"),
    }  # fmt: skip
    script = str(Path(__file__).parent / "robot.py")
    parameters = {
        **CHIRP, "joint": JOINT, "auto_start": True, "chirp.amplitude": amplitude, "chirp.duration_s": 3.0,
        "limits.require_urdf": True, "limits.state_timeout_s": 1.0, "recording.directory": str(folder / "bags"),
    }  # fmt: skip
    given = [word for key, value in parameters.items() for word in ("-p", f"{key}:={json.dumps(value)}")]
    ours = [sys.executable, "-m", "flex_ident.nodes", "chirp_exciter", "--ros-args", "-r", f"__ns:=/{side}", *given]
    for name, command in ((f"{side}_robot", [sys.executable, script, json.dumps(robot)]), (f"{side}_exciter", ours)):
        with made.log(name).open("ab") as out:
            apart = without_shared_memory(os.environ, get_rmw_implementation_identifier())
            made.processes[name] = subprocess.Popen(command, stdout=out, stderr=out, env=apart)


def test_two_robots_by_their_namespaces_alone(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        # A link encoder of neither, which both must leave alone.
        others = made.node.create_publisher(JointState, "/link_joint_states", 10)
        made.node.create_timer(0.05, lambda: others.publish(JointState(name=[JOINT], position=[1.0])))
        for side in SIDES:
            robot_and_exciter(made, side)
        end = time.monotonic() + 60.0
        for side in SIDES:
            status = made.ended(f"{side}_exciter", end - time.monotonic())
            assert status == 0, made.output(f"{side}_exciter")
    for side, (position, amplitude) in SIDES.items():
        rows = [line.split() for line in (tmp_path / side / "truth").read_text().splitlines()]
        truth = np.array([row for row in rows if len(row) == 7], float)
        swing = np.abs(truth[:, 2] - position).max()
        assert 0.3 * amplitude < swing < 1.2 * amplitude
        bag = next((tmp_path / side / "bags").iterdir())
        with AnyReader([bag]) as reader:
            topics = {connection.topic for connection in reader.connections}
        assert topics == {f"/{side}/joint_states", f"/{side}/chirp_exciter/reference"}
        limits = json.loads(yaml.safe_load((bag / RUN_FILE).read_text())["flex_ident_limits"])
        assert float(limits["position_max"]) == (0.2 if side == "left" else 1.0)
