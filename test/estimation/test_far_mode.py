"""A part of the link swings above the band: K is what it is, or known as poorly as the recording leaves it."""

import math

import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

pytestmark = pytest.mark.slow
EXPERIMENT = Experiment(duration_s=25.0, sample_rate_hz=500.0, end_frequency_hz=40.0)
BAND_HZ = 40.0


def with_far_mode(share: float, frequency_hz: float) -> JointModel:
    """The cobot with a share of its link behind a further spring."""
    own = dict(COBOT_JOINT.parameters)
    inertia, omega = share * own["JL"], 2.0 * math.pi * frequency_hz
    second = {"inertia": inertia, "stiffness": inertia * omega**2, "damping": 0.02 * inertia * omega}
    return JointModel({**own, "JL": own["JL"] - inertia}, {"second_mode": second}, joint="far")


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("share", "frequency_hz"),
    [(0.15, 1.4 * BAND_HZ), (0.1, 1.1 * BAND_HZ), (0.1, 2.5 * BAND_HZ), (0.2, 4.0 * BAND_HZ)],
)
def test_a_link_encoder_tells_a_mode_above_the_band_from_stiffness(share: float, frequency_hz: float) -> None:
    recording = virtual_recording(
        with_far_mode(share, frequency_hz), EXPERIMENT, MeasurementChain(torque_noise=0.01), seed=5
    )
    result = identify(recording, IdentifyOptions(sensors="motor+link"))
    truth = COBOT_JOINT.parameters
    for key in ("Jm", "K", "JL"):
        p = result.parameter(key)
        assert p.identifiable, key
        assert abs(p.value - truth[key]) < 3.0 * p.std, (key, p)
    assert result.parameter("K").std < 0.01 * truth["K"]


def test_the_motor_alone_says_what_it_takes_for_granted() -> None:
    recording = virtual_recording(with_far_mode(0.03, 1.2 * BAND_HZ), EXPERIMENT, MeasurementChain(torque_noise=0.01))
    result = identify(recording, IdentifyOptions(sensors="motor"))
    notice = next(n for n in result.notices if n.code == "link_taken_as_rigid")
    k, truth = result.parameter("K"), COBOT_JOINT.value("K")
    assert notice.case == "far"
    assert truth - k.value == pytest.approx(0.01 * notice.numbers["moved_percent"] * truth, rel=0.5)
