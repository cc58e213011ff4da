"""How nodes start and end: help without ROS's network, signals at any time, errors with the node's name once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import rig

from flex_ident.nodes import chirp_exciter, identifier, simulated_joint

pytestmark = pytest.mark.ros
MAINS = {"chirp_exciter": chirp_exciter.main, "identifier": identifier.main, "simulated_joint": simulated_joint.main}
KEYS = {
    "chirp_exciter": "limits.tracking_error",
    "identifier": "bag_directories",
    "simulated_joint": "effects.backlash",
}


@pytest.mark.parametrize("node", list(MAINS))
@pytest.mark.parametrize("option", ["--help", "-h"])
def test_help_tells_the_parameters_and_starts_nothing(
    node: str, option: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rclpy.init", lambda **_: pytest.fail("DDS was started"))
    assert MAINS[node]([option, "--ros-args", "-p", "x:=1"]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"usage: ros2 run flex_ident {node}")
    assert f"config/{node}.yaml" in said
    assert KEYS[node] in said


@pytest.mark.parametrize(
    ("node", "given", "text"),
    [
        ("chirp_exciter", ["joint:=a", "rate_hz:=1.0"], "rate_hz is 1.0"),
        ("simulated_joint", ["rate_hz:=1.0"], "rate_hz is 1.0"),
        ("identifier", ["method:=guess"], "method is 'guess'"),
        ("identifier", ["jont:=a"], "unknown parameter 'jont': did you mean 'joint'?"),
        ("identifier", ["gear_ratio:=0.0"], "gear_ratio is 0.0: expected a number other than zero."),
        ("identifier", ["without:=XX"], "--without XX: expected one of"),
    ],
)
def test_what_is_wrong_is_said_with_the_name_once(
    node: str, given: list[str], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    handlers = [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM)]
    assert MAINS[node](["--ros-args", *(a for g in given for a in ("-p", g))]) == 2
    assert capsys.readouterr().err.startswith(f"{node}: {text}")
    assert [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM)] == handlers


def test_the_identifier_takes_a_commands_file_and_refuses_nonsense_when_set(tmp_path: Path) -> None:
    file = tmp_path / "shared.yaml"
    file.write_text("/**:\n  ros__parameters:\n    out: somewhere\n    rigid: false\n")
    with rig(tmp_path) as made:
        arguments = [sys.executable, "-m", "flex_ident.nodes", "identifier", "--ros-args", "--params-file", str(file)]
        with made.log("identifier").open("ab") as out:
            made.processes["identifier"] = subprocess.Popen(arguments, stdout=out, stderr=out)

        def refusal(key: str, value: Any) -> str:
            return made.set_parameter("identifier", key, value)

        assert "other than zero" in refusal("gear_ratio", 0.0)
        assert "expected one of FVm" in refusal("without", "XX")
        assert "unknown effect 'nope'" in refusal("effects", "backlash,nope")
        assert "unknown effect 'nope'" in refusal("add", "nope")
        assert refusal("without", "MX,MY") == ""
        assert refusal("gear_ratio", 100.0) == ""
        made.processes["identifier"].send_signal(signal.SIGINT)
        assert made.ended("identifier", 10.0) == 0, made.output("identifier")


STARTING = """
import signal, sys, os, rclpy
{ignore}
from flex_ident.nodes import simulated_joint as s
made = s.SimulatedJoint.__init__
def slow(self):
    made(self)
    os.kill(os.getpid(), signal.{name})
s.SimulatedJoint.__init__ = slow
sys.exit(s.main(["--ros-args", "-p", "rate_hz:=10.0", "-p", "speed:=0.01"]))
"""


IGNORED = "signal.signal(signal.SIGINT, signal.SIG_IGN)"


@pytest.mark.parametrize(
    ("name", "ignore"),
    [
        ("SIGINT", ""),
        ("SIGTERM", IGNORED),
        pytest.param("SIGTERM", "", marks=pytest.mark.campaign),
        pytest.param("SIGINT", IGNORED, marks=pytest.mark.campaign),
    ],
    ids=["shell", "background_term", "shell_term", "background"],
)
def test_a_signal_that_comes_while_the_node_is_made_ends_it(name: str, ignore: str) -> None:
    began = time.monotonic()
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    done = subprocess.run(
        [sys.executable, "-c", STARTING.format(name=name, ignore=ignore)],
        capture_output=True, text=True, timeout=30, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert time.monotonic() - began < 20.0


@pytest.mark.parametrize("node", list(MAINS))
@pytest.mark.parametrize("library", ["_multiarray_umath", pytest.param("_rclpy", marks=pytest.mark.campaign)])
def test_a_signal_that_comes_while_a_node_imports_ends_it(node: str, library: str) -> None:
    """The signal comes as soon as the process has loaded a library, however long the machine takes for that: before its
    own first line nothing but Python can answer."""
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    process = subprocess.Popen(
        [sys.executable, "-m", "flex_ident.nodes", node, "--ros-args", "-p", "joint:=a"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip
    loaded, until = Path(f"/proc/{process.pid}/maps"), time.monotonic() + 20.0
    while library not in loaded.read_text(encoding="utf-8"):
        assert time.monotonic() < until
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 0, said
    assert "Traceback" not in said


def test_an_automatic_start_that_is_interrupted_has_failed(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.exciter(auto_start=True)
        made.spin(0.5)
        made.processes["chirp_exciter"].send_signal(signal.SIGINT)
        assert made.ended("chirp_exciter", 15.0) == 3
        assert "chirp_exciter: stopped by SIGINT before it moved" in made.output("chirp_exciter")
