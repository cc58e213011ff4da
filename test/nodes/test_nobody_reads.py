"""A node whose output nobody reads any more ends as it would otherwise."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import JOINT, rig

pytestmark = pytest.mark.ros


def test_an_exciter_is_stopped_by_a_signal_where_nobody_reads_what_it_says(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.simulated_joint()
        read, write = os.pipe()
        command = [
            sys.executable, "-m", "flex_ident.nodes", "chirp_exciter", "--ros-args", "-p", f"joint:={JOINT}",
            "-p", f"recording.directory:={tmp_path / 'bags'}",
        ]  # fmt: skip
        made.processes["chirp_exciter"] = process = subprocess.Popen(command, stdout=write, stderr=write)
        os.close(write)
        os.close(read)
        assert made.start_exciting() == ""
        assert made.until("exciting")
        made.spin(0.5)
        process.send_signal(signal.SIGTERM)
        assert made.ended("chirp_exciter") == 3
        assert made.states[-1] == "aborted"
        assert (made.bag() / "metadata.yaml").exists()
