"""Long work of the identifier behaves as an action would: progress, cancel, an answer to everybody."""

from __future__ import annotations

import re
import signal
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rig import LATCHED, Rig, rig
from std_srvs.srv import Trigger

from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.virtual_joint import COBOT_JOINT, Experiment

pytestmark = pytest.mark.ros
GUIDE = (Path(__file__).resolve().parents[2] / "docs" / "calling.md").read_text(encoding="utf-8")


def watched(made: Rig, folder: Path, node: str = "/identifier") -> list[dict[str, str]]:
    """Start an identifier on a bag; what its state says from now on."""
    write_virtual_bag(folder / "bag", COBOT_JOINT, Experiment(duration_s=12.0, sample_rate_hz=250.0))
    states: list[dict[str, str]] = []

    def said(status: DiagnosticStatus) -> None:
        states.append({"message": status.message, "name": status.name, **{v.key: v.value for v in status.values}})

    made.node.create_subscription(DiagnosticStatus, f"{node}/state", said, LATCHED)
    made.start("identifier", {"bag_directories": [str(folder)], "bag": "bag", "output_directory": ""})
    return states


def begun(made: Rig, states: list[dict[str, str]], service: str) -> Any:
    """A call that is not waited for, once its work has begun; the future of its answer."""
    client = made.node.create_client(Trigger, service)
    assert client.wait_for_service(45.0)
    made.spin(0.3)
    future = client.call_async(Trigger.Request())
    until = time.monotonic() + 30.0
    while time.monotonic() < until and not any(int(s["progress_percent"]) >= 12 for s in states):
        made.spin(0.05)
    assert not future.done()
    return future


def answered(made: Rig, future: Any, seconds: float) -> Any:
    """The answer, which must come in that time."""
    until = time.monotonic() + seconds
    while time.monotonic() < until and not future.done():
        made.spin(0.02)
    assert future.done(), made.output("identifier")
    return future.result()


def test_a_search_is_cancelled_and_the_next_call_runs_to_its_end(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        states = watched(made, tmp_path)
        future = begun(made, states, "/identifier/explain_gap")
        busy, message = made.call("/identifier/identify")
        assert not busy
        assert re.match(r"busy with explain_gap, \d+ % done", message)
        assert made.call("/identifier/cancel") == (True, "stopping explain_gap: its caller is answered.")
        answer = answered(made, future, 5.0)
        assert (answer.success, answer.message) == (False, "stopped: cancelled by ~/cancel.")
        made.spin(0.3)
        assert states[-1]["message"] == "idle, latest: stopped: cancelled by ~/cancel."
        assert made.call("/identifier/cancel") == (False, "nothing to cancel.")
        states.clear()
        success, _ = made.call("/identifier/identify", 60.0)
        made.spin(0.3)
    assert success
    shares = [int(s["progress_percent"]) for s in states]
    assert all(b >= a for a, b in pairwise(shares))
    assert len(set(shares)) > 4
    assert states[-1]["state"] == "idle"
    assert states[-1]["latest"] == "trusted"
    assert states[-1]["name"] == "identifier: identification"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_node_that_ends_in_mid_search_answers_first(number: signal.Signals, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        states = watched(made, tmp_path)
        future = begun(made, states, "/identifier/explain_gap")
        made.processes["identifier"].send_signal(number)
        answer = answered(made, future, 5.0)
        assert made.ended("identifier", 5.0) == 0
        assert answer.message == "stopped: the node ends."
        assert "never retrieved" not in made.output("identifier")


def test_the_client_of_the_guide_gets_its_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (client,) = re.findall(r"```python\n(.*?)```", GUIDE, re.S)
    with rig(tmp_path) as made:
        heard: list[DiagnosticArray] = []
        made.node.create_subscription(DiagnosticArray, "/diagnostics", heard.append, 10)
        watched(made, tmp_path)
        assert made.node_appears("identifier")
        exec(compile(client, "docs/calling.md", "exec"), {"node": made.node})
        made.spin(1.2)
    printed = capsys.readouterr().out
    assert "identify, " in printed
    assert '"verdict": "trusted"' in printed
    assert any(
        s.name == "identifier: identification" and s.hardware_id == "identifier" for m in heard for s in m.status
    )
