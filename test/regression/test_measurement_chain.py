"""What the weighted fit says of the measurement chain: when the link was read, and how sure it is of the rest."""

import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=15.0)
CHAIN = MeasurementChain.with_bits(20, 20, torque_noise=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("skew", [2e-3, pytest.param(-2e-3, marks=pytest.mark.campaign)])
@pytest.mark.parametrize("method", ["auto", "weighted"])
def test_a_skew_of_the_link_encoder_has_the_right_sign(skew: float, method: str) -> None:
    late = 0.4 * skew if method == "auto" else skew  # beyond a sample it is an effect, which auto leaves to explain_gap
    model = COBOT_JOINT.with_effect("encoder_skew", {"skew": late})
    result = identify(virtual_recording(model, EXPERIMENT, CHAIN, seed=1), IdentifyOptions(method=method))
    found = {p.key: p.value for p in result.measurement}
    assert found["link_skew"] == pytest.approx(late, rel=0.1)


@pytest.mark.parametrize("seed", range(4))
def test_the_weighted_fits_intervals_hold_the_truth(seed: int) -> None:
    recording = virtual_recording(COBOT_JOINT, EXPERIMENT, CHAIN, seed=seed)
    result = identify(recording, IdentifyOptions(method="weighted"))
    for key in ("Jm", "K", "JL", "FVm", "FV"):
        p = result.parameter(key)
        assert abs(p.value - COBOT_JOINT.value(key)) < 2.6 * p.std, key
