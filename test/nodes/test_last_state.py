"""Whoever listens to the exciter has its last state, also where they could not listen while it ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rclpy.utilities import get_rmw_implementation_identifier
from rig import rig

from flex_ident.nodes.transports import without_shared_memory

pytestmark = pytest.mark.ros


def test_the_last_state_comes_to_a_listener_that_was_held_up(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.simulated_joint()
        command = [sys.executable, str(Path(__file__).parent / "slow_listener.py")]
        apart = without_shared_memory(os.environ, get_rmw_implementation_identifier())
        with made.log("listener").open("ab") as out:
            made.processes["listener"] = listener = subprocess.Popen(command, stdout=out, stderr=out, env=apart)
        assert made.node_appears("slow_listener")
        made.exciter(**{"chirp.duration_s": 3.0, "chirp.fade_s": 0.5, "rate_hz": 1000.0})
        assert made.start_exciting() == ""
        assert made.until("exciting"), made.output("chirp_exciter")
        made.spin(1.0)
        assert "exciting" in made.output("listener")
        listener.send_signal(signal.SIGSTOP)
        assert made.until("done", 30.0), made.output("chirp_exciter")
        made.spin(0.5)
        listener.send_signal(signal.SIGCONT)
        assert made.ended("chirp_exciter") == 0, made.output("chirp_exciter")
        ends = time.monotonic() + 5.0
        while time.monotonic() < ends and "done" not in made.output("listener"):
            made.spin(0.1)
        assert "done" in made.output("listener").splitlines(), made.output("listener")
        assert "has not taken" not in made.output("chirp_exciter")
