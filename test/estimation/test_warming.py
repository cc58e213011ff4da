"""A gear that warms up beside a link that does not: friction of the motor falls over the recording."""

import pytest

from flex_ident.estimation.identification import identify
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording


@pytest.mark.slow
def test_a_motor_that_warms_up_alone_is_suspected_and_the_intervals_hold_the_cold_friction() -> None:
    truth = COBOT_JOINT.with_effect("friction_drift", {"rate_motor": -0.008})
    experiment = Experiment(duration_s=24.0, sample_rate_hz=500.0)
    result = identify(virtual_recording(truth, experiment, MeasurementChain(torque_noise=0.005), seed=4))
    assert result.verdict == "doubtful"
    assert [n.subject for n in result.notices if n.code == "cause_suspected"] == ["friction_drift"]
    for key in ("Jm", "K", "JL", "FVm", "FSm"):
        p = result.parameter(key)
        assert abs(p.value - truth.value(key)) < 3.0 * p.std, p
    for key in ("FV", "FS"):
        assert abs(result.parameter(key).value - truth.value(key)) < 0.05 * truth.value(key)
