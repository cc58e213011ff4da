"""An absolute value is told from an effort that gravity keeps on one side, by its corners at zero."""

from dataclasses import replace

import numpy as np
import pytest

from flex_ident.errors import SignalError
from flex_ident.recording import Recording
from flex_ident.recording.signs import brakes, corners_at_zero, refuse_unsigned
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

CHAIN = MeasurementChain.with_bits(17, 17, torque_noise=0.01)


@pytest.fixture(scope="module", params=[250.0, 1000.0])
def recording(request: pytest.FixtureRequest) -> Recording:
    experiment = Experiment(duration_s=20.0, sample_rate_hz=request.param)
    return virtual_recording(COBOT_JOINT, experiment, CHAIN, seed=3, link=False)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_absolute_value_is_refused(recording: Recording, sign: float) -> None:
    noise = 0.01 * np.std(recording.motor_torque) * np.random.default_rng(1).standard_normal(recording.time.size)
    unsigned = replace(recording, motor_torque=sign * np.abs(recording.motor_torque) + noise)
    with pytest.raises(SignalError, match="never changes its sign"):
        refuse_unsigned(unsigned)


def test_an_absolute_value_of_little_that_changes_its_sign_is_refused(recording: Recording) -> None:
    torque = recording.motor_torque - np.mean(recording.motor_torque) + 0.5 * np.max(np.abs(recording.motor_torque))
    with pytest.raises(SignalError, match="never changes its sign"):
        refuse_unsigned(replace(recording, motor_torque=np.abs(torque)))


def test_an_effort_with_its_sign_passes(recording: Recording) -> None:
    refuse_unsigned(recording)


@pytest.mark.parametrize("share", [0.0, 0.001, 0.01, 0.03, 0.1, 1.0])
def test_gravity_that_keeps_the_effort_on_one_side_passes(recording: Recording, share: float) -> None:
    """Down to where the least effort just meets zero: there it is flat."""
    torque = recording.motor_torque
    held = torque - np.min(torque) + share * np.ptp(torque)
    assert corners_at_zero(held) == 0
    refuse_unsigned(replace(recording, motor_torque=held))


@pytest.mark.parametrize("share", [0.0, 0.01, 0.1])
def test_a_steady_swing_that_just_meets_zero_each_time_passes(share: float) -> None:
    """With dry friction, which jumps at each reversal."""
    t = np.arange(20000) / 500.0
    noise = 0.02 * np.random.default_rng(2).standard_normal(t.size)
    swing = 10.0 * np.sin(2.0 * np.pi * 0.8 * t) + 1.5 * np.sign(np.cos(2.0 * np.pi * 0.8 * t))
    torque = swing + noise
    assert corners_at_zero(torque - np.min(torque) + share) == 0
    assert corners_at_zero(np.abs(10.0 * np.sin(2.0 * np.pi * 0.8 * t) + noise)) > 20


@pytest.mark.parametrize("sinking", [0.0, -0.001])
def test_a_weight_that_sinks_slowly_does_not_reverse_the_effort(sinking: float) -> None:
    """A motor that holds a weight takes up work while it gives way: that says nothing of the effort's sign."""
    t = np.arange(8000) / 200.0
    v = 0.0005 * np.cos(2.0 * np.pi * 1.5 * t)
    q = sinking * t + 0.0005 * np.sin(2.0 * np.pi * 1.5 * t) / (2.0 * np.pi * 1.5)
    torque = 2.5 + 100.0 * v
    assert not brakes(Recording("elbow", 200.0, q, torque))
    assert brakes(Recording("elbow", 200.0, q, -torque))
