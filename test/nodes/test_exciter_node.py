"""`chirp_exciter` as a process over DDS: interfaces, parameters, and what its recordings hold."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy", reason="needs rclpy")
import mcap.reader
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.srv import DescribeParameters, ListParameters
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from rig import CHIRP, JOINT, Rig, rig
from rosbags.highlevel import AnyReader
from scipy.optimize import least_squares

from flex_ident import __version__
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.excitation import ChirpSettings, chirp_reference
from flex_ident.excitation.motions import SHORTEST_TRAVEL_S
from flex_ident.nodes import chirp_exciter
from flex_ident.nodes.bag_file import RUN_FILE

pytestmark = pytest.mark.ros
CONFIG = Path(__file__).resolve().parents[2] / "config"
COMMAND = [sys.executable, "-m", "flex_ident.nodes", "chirp_exciter", "--ros-args"]
SHORT = {"chirp.duration_s": 3.0, "chirp.fade_s": 0.5}
EXTRA = "/extra"


Started = Callable[..., tuple[int, str]]


@pytest.fixture
def started_with(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Started:
    """Exit status and standard error of an exciter that must not start, with those arguments."""

    def started(*arguments: str) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["chirp_exciter", "--ros-args", *arguments])
        return chirp_exciter.main(), capsys.readouterr().err

    return started


def publish_extra(made: Rig) -> list[bytes]:
    """A topic of a nested type that appears in mid-chirp, best effort; the bytes published while it was recorded."""
    quality = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = made.node.create_publisher(DiagnosticArray, EXTRA, quality)
    sent: list[bytes] = []
    while made.processes["chirp_exciter"].poll() is None and "ramping_down" not in made.states:
        values = [KeyValue(key="k", value=str(len(sent)))] * (len(sent) % 4)
        message = DiagnosticArray(status=[DiagnosticStatus(name="extra", values=values)] * 2)
        if publisher.get_subscription_count():
            sent.append(bytes(serialize_message(message)))
            publisher.publish(message)
        made.spin(0.05)
    return sent


@pytest.mark.parametrize("storage", ["mcap", pytest.param("sqlite3", marks=pytest.mark.campaign)])
def test_a_recording_opens_everywhere_and_holds_what_was_sent(storage: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.simulated_joint()
        made.exciter(auto_start=True, **SHORT, **{
            "recording.storage": storage, "recording.topics": ["/link_joint_states", EXTRA],
        })  # fmt: skip
        assert made.until("exciting", 30.0), made.output("chirp_exciter")
        sent = publish_extra(made)
        assert made.ended("chirp_exciter") == 0, made.output("chirp_exciter")
        assert ", 0 lost" in made.output("chirp_exciter")
        bag = made.bag()
        references = list(made.references)
    assert len(sent) > 20
    with AnyReader([bag]) as reader:
        recorded = {c.topic: [bytes(raw) for _, _, raw in reader.messages([c])] for c in reader.connections}
        # Padding may hold anything, and a message is serialised once for the wire and once for this test.
        came = [deserialize_message(raw, DiagnosticArray) for raw in recorded[EXTRA]]
        assert came == [deserialize_message(raw, DiagnosticArray) for raw in sent[: len(came)]]
        assert len(came) >= len(sent) - 10
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
    information = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]["custom_data"]
    assert information == yaml.safe_load((bag / RUN_FILE).read_text())
    assert information["flex_ident_version"] == __version__
    assert json.loads(information["flex_ident_parameters"])["chirp.duration_s"] == 3.0
    assert json.loads(information["flex_ident_limits"])["position_max"] == "0.4"
    if storage == "mcap":
        with next(bag.glob("*.mcap")).open("rb") as stream:
            reader = mcap.reader.make_reader(stream, validate_crcs=True)
            counts: dict[str, int] = {}
            for _, channel, _ in reader.iter_messages():
                counts[channel.topic] = counts.get(channel.topic, 0) + 1
            statistics = reader.get_summary().statistics
        assert counts == {topic: len(messages) for topic, messages in recorded.items()}
        assert statistics.message_count == sum(counts.values())
    recording = read_recording(bag, SignalSelection(joint=JOINT, sensors="motor+link"))
    assert recording.reference is not None
    assert np.std(recording.motor_position - recording.reference) < 0.05
    reference_is_exact(references)


def reference_is_exact(references: list[tuple[float, float, float]]) -> None:
    """The reference that was published is the chirp at its stamps: a function of time and of nothing else."""
    settings = ChirpSettings(
        CHIRP["chirp.start_frequency_hz"], CHIRP["chirp.end_frequency_hz"], 3.0, CHIRP["chirp.amplitude"], fade_s=0.5
    )  # fmt: skip
    chirp = chirp_reference(settings)
    stamps, positions, velocities = np.array(references).T
    moving = np.flatnonzero(np.abs(velocities) > 1e-3)
    moving = moving[stamps[moving] > stamps[moving[0]] + SHORTEST_TRAVEL_S]  # behind the first small motion
    inside = slice(moving[0], moving[0] + 1200)

    def errors(unknown: np.ndarray) -> np.ndarray:
        start, center = unknown
        wanted = np.array([chirp.at(stamp - start)[0] for stamp in stamps[inside] - stamps[moving[0]]])
        return wanted + center - positions[inside]

    # Where it starts is fitted, robustly: a tick that came late moves the reference no faster than it may, so that the
    # next ones are behind the chirp.
    far = np.abs(errors(least_squares(errors, (-0.02, 0.0), loss="cauchy", f_scale=1e-5, x_scale=(1e-3, 1e-4)).x))
    assert np.median(far) < 2e-6
    assert np.quantile(far, 0.98) < 5e-4


@pytest.mark.parametrize(
    ("robot", "exciter"),
    [
        pytest.param(
            {"controller.interface": "velocity", "controller.topic": "/velocities"},
            {"command.interface": "velocity", "command.topic": "/velocities"}, marks=pytest.mark.campaign,
        ),
        ({"controller.interface": "effort", "controller.topic": "/efforts", "other_joints": ["shoulder"],
          "controller.joints": ["shoulder", JOINT]},
         {"command.interface": "effort", "command.topic": "/efforts", "command.joints": ["shoulder", JOINT],
          "command.position_gain": 1000.0, "command.velocity_gain": 60.0, "command.hold_position_gains": [100.0],
          "command.hold_velocity_gains": [10], "rate_hz": 1000}),
        ({"controller.type": "joint_trajectory", "controller.topic": "/trajectories"},
         {"command.type": "joint_trajectory", "command.topic": "/trajectories"}),
    ],
    ids=["velocity", "effort", "trajectory"],
)  # fmt: skip
def test_each_kind_of_command_moves_the_joint(robot: dict[str, Any], exciter: dict[str, Any], tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.simulated_joint(rate_hz=1000.0, **robot)
        made.exciter(auto_start=True, **SHORT, **exciter)
        assert made.ended("chirp_exciter", 40.0) == 0, made.output("chirp_exciter")
        recording = read_recording(made.bag(), SignalSelection(joint=JOINT, sensors="motor"))
    assert recording.reference is not None
    assert np.corrcoef(recording.motor_position, recording.reference)[0, 1] > 0.9


def test_parameters_are_described_ranged_and_changed_while_nothing_moves(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.exciter(start_position=0.1)
        names = made.ask(ListParameters, "/chirp_exciter/list_parameters", ListParameters.Request()).result.names
        ours = [n for n in names if n not in ("use_sim_time", "start_type_description_service")]
        asked = DescribeParameters.Request(names=ours)
        answer = made.ask(DescribeParameters, "/chirp_exciter/describe_parameters", asked)
        described = {d.name: d for d in answer.descriptors}
        assert len(described) >= 35
        assert all(d.description for d in described.values())
        assert described["chirp.duration_s"].floating_point_range[0].to_value == 3600.0
        assert "constant_velocity" in described["chirp.profile"].additional_constraints
        assert made.set_parameter("chirp_exciter", "chirp.amplitude", 0.15) == ""
        for path in ("/tmp/elsewhere", str(tmp_path / "bags" / ".." / "x"), f"{tmp_path}/bags2", "~"):
            refused = made.set_parameter("chirp_exciter", "recording.directory", path)
            assert "at run time it must stay inside" in refused, path
        assert made.set_parameter("chirp_exciter", "recording.directory", str(tmp_path / "bags" / "today")) == ""
        assert made.set_parameter("chirp_exciter", "start_position", "gravity_rest") != ""
        assert made.set_parameter("chirp_exciter", "my", 3.0) == ""
        assert made.set_parameter("chirp_exciter", "start_position", "gravity_rest") == ""
        assert "constant_position" in made.set_parameter("chirp_exciter", "chirp.profile", "steady")
        assert "position_min" in made.set_parameter("chirp_exciter", "limits.position_min", 1e10)
        assert "whole number" in made.set_parameter("chirp_exciter", "chirp.repeats", 1.5)
        assert "read" in made.set_parameter("chirp_exciter", "command.topic", "/x").replace("-", "")
        made.processes["chirp_exciter"].send_signal(signal.SIGINT)
        assert made.ended("chirp_exciter") == 0, made.output("chirp_exciter")


@pytest.mark.parametrize(
    ("given", "texts"),
    [
        ({"joint": "a", "chirp": {"amplitud": 0.1}}, ("unknown parameter 'chirp.amplitud'", "'chirp.amplitude'")),
        ({"joint": "a", "rate_hz": 1.0}, ("rate_hz is 1.0", "from 10 to 5000")),
        ({"joint": "a", "chirp": {"sweep": 3}}, ("chirp.sweep is 3", "one of logarithmic, linear")),
        ({"joint": "a", "recording": {"topics": "/x"}}, ("recording.topics is '/x'", "a list of texts")),
        ({"joint": "a", "start_position": "there"}, ("start_position is there", "gravity_rest")),
        (
            {"joint": "a", "limits": {"position_min": 1.0, "position_max": 0.0}},
            ("limits.position_min 1.0 is not below",),
        ),
        ({"joint": "a", "command": {"joints": ["b", "c"]}}, ("does not hold the joint 'a'",)),
        ({"joint": "a", "command": {"hold_position_gains": ["x"]}}, ("hold_position_gains",)),
        ({}, ("joint is empty",)),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(
    given: dict[str, Any], texts: tuple[str, ...], tmp_path: Path, started_with: Started
) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": given}}))
    status, said = started_with("--params-file", str(file))
    assert status == 2
    assert said.count("\n") == 1, said
    for text in texts:
        assert text in said
    if texts[0].startswith(("unknown", "rate", "chirp", "recording")):
        assert str(file) in said


def test_the_shipped_configurations_load() -> None:
    files = [CONFIG / f"{name}.yaml" for name in ("chirp_exciter", "ur", "franka", "ros2_control")]
    processes = [
        subprocess.Popen([*COMMAND, "--params-file", str(file)], stderr=subprocess.PIPE, text=True) for file in files
    ]
    time.sleep(4.0)
    for file, process in zip(files, processes, strict=True):
        running = process.poll() is None
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=20.0)
        assert running, f"{file}: {said}"
        assert process.returncode == 0, f"{file}: {said}"


def test_it_says_what_it_waits_for_and_which_topics_do_not_come(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.exciter(**{"recording.topics": ["/nothing"], "chirp.duration_s": 3.0})
        end = time.monotonic() + 20.0
        while "still missing" not in made.output("chirp_exciter") and time.monotonic() < end:
            made.spin(0.2)
        said = made.output("chirp_exciter")
        assert "idle: call /chirp_exciter/start" in said
        assert "still missing: no /robot_description has arrived" in said
        made.simulated_joint()
        end = time.monotonic() + 20.0
        while "all that it needs is there" not in made.output("chirp_exciter"):
            assert time.monotonic() < end, made.output("chirp_exciter")
            made.spin(0.2)
        made.spin(0.5)  # the first joint states come after the topic that they come by
        success, message = made.call("/chirp_exciter/start")
        assert success, message
        assert message.endswith("; not received so far: /nothing (nobody publishes it)")
        made.spin(0.3)
        made.call("/chirp_exciter/stop")
        made.ended("chirp_exciter")
        said = made.output("chirp_exciter")
    assert "not received so far: /nothing (nobody publishes it)" in said
    assert "not in the recording: /nothing (nobody publishes it)" in said
    assert "real-time priority" not in said
    assert "chirp_exciter: chirp_exciter" not in said


@pytest.mark.parametrize("kind", ["pipe", "folder"])
def test_a_parameter_file_that_is_none_is_not_waited_for(kind: str, tmp_path: Path, started_with: Started) -> None:
    path = tmp_path / kind
    path.mkdir() if kind == "folder" else os.mkfifo(path)
    status, said = started_with("--params-file", str(path))
    assert status == 2
    assert said == f"chirp_exciter: --params-file {path}: it is no file, but a folder, a pipe or a device.\n"


def test_simulated_time_is_refused(tmp_path: Path, started_with: Started) -> None:
    status, said = started_with("-p", "joint:=a", "-p", "use_sim_time:=true")
    assert status == 2
    assert "use_sim_time is true" in said
    with rig(tmp_path) as made:
        made.exciter()
        assert "use_sim_time is true" in made.set_parameter("chirp_exciter", "use_sim_time", True)
