"""Parameters from an effort that was cut toward zero to whole steps, as a drive's firmware does it."""

from dataclasses import replace

import numpy as np
import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.notices import Code
from flex_ident.recording.mending import mended_signals
from flex_ident.recording.recording import Signal
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording


@pytest.mark.slow
@pytest.mark.parametrize(
    ("step", "code"), [(1.0, Code.EFFORT_TRUNCATED), pytest.param(0.02, Code.EFFORT_STEPS, marks=pytest.mark.campaign)]
)
def test_an_effort_that_was_cut_toward_zero_is_put_right_or_in_the_intervals(step: float, code: Code) -> None:
    experiment = Experiment(duration_s=20.0, sample_rate_hz=500.0, profile="rich")
    recording = virtual_recording(COBOT_JOINT, experiment, MeasurementChain.with_bits(17, 20), seed=10)
    cut = Signal("motor_torque", "e", "header", recording.time, step * np.trunc(recording.motor_torque / step))
    motor = Signal("motor_position", "q", "header", recording.time, recording.motor_position)
    signals, notices = mended_signals([motor, cut])
    [effort] = [s for s in signals if s.role == "motor_torque"]
    sampling = tuple(replace(s, untold_step=effort.untold_step) for s in recording.sampling if s.role == effort.role)
    told = replace(recording, motor_torque=effort.values, notices=tuple(notices), sampling=sampling)
    result = identify(told, IdentifyOptions())
    assert code in {n.code for n in result.notices}
    for key in ("Jm", "K", "JL", "FSm", "FS", "MY"):
        p = result.parameter(key)
        assert not p.identifiable or abs(p.value - COBOT_JOINT.value(key)) < 3.0 * p.std, p
