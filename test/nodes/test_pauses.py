"""A computer that pauses: neither the virtual joint nor the exciter makes a jump of it."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import JOINT, VELOCITY_LIMIT, rig

from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection

pytestmark = pytest.mark.ros
PAUSE_S = 0.35
"""At 500 Hz: of more than some 250 commands that a stopped process has yet to take, the middleware drops some."""


@pytest.mark.parametrize("node", ["simulated_joint", "chirp_exciter"])
def test_a_pause_is_no_jump(node: str, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.simulated_joint()
        made.exciter(**{"limits.state_timeout_s": 1.0, "chirp.duration_s": 3.0, "rate_hz": 500.0})
        assert made.start_exciting() == ""
        assert made.until("exciting"), made.output("chirp_exciter")
        for _ in range(2):
            made.spin(0.4)
            made.processes[node].send_signal(signal.SIGSTOP)
            time.sleep(PAUSE_S)  # not spinning: who listens to a process that is stopped may be held up with it
            made.processes[node].send_signal(signal.SIGCONT)
        assert made.ended("chirp_exciter") == 0, made.output("chirp_exciter")
        recording = read_recording(made.bag(), SignalSelection(joint=JOINT, sensors="motor"))
    speed = np.abs(np.diff(recording.motor_position)) * recording.sample_rate_hz
    assert np.max(speed) < 0.9 * VELOCITY_LIMIT
    assert made.largest_speed() <= VELOCITY_LIMIT
