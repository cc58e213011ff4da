"""Parameters at their bound, models that do not fit the method, joints that slide."""

from pathlib import Path

import pytest

from flex_ident.errors import ConfigurationError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap import GapOptions
from flex_ident.jobs.options import given_model
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=15.0)
CHAIN = MeasurementChain.with_bits(20, 20, torque_noise=0.01)


@pytest.mark.campaign
def test_a_parameter_at_its_bound_has_an_interval_on_the_other_side() -> None:
    model = JointModel({**COBOT_JOINT.parameters, "FS": 0.03, "FV": 0.0})
    met = 0
    for seed in (1, 2, 3):
        experiment = Experiment(duration_s=12.0, sample_rate_hz=500.0)
        recording = virtual_recording(model, experiment, MeasurementChain(torque_noise=0.02), seed=seed, link=False)
        p = identify(recording, IdentifyOptions(sensors="motor")).parameter("FV")
        low, high = p.interval
        assert high > 0.0
        assert abs(p.value) < 4.0 * p.std
        met += p.at_bound
        assert not p.at_bound or low == p.value == 0.0
    assert met > 0


def test_a_model_that_a_method_does_not_use_is_told() -> None:
    recording = virtual_recording(COBOT_JOINT, EXPERIMENT, CHAIN)
    given = COBOT_JOINT.with_effect("backlash", {"gap": 1e-3})
    for method in ("weighted", "paper"):
        result = identify(recording, IdentifyOptions(method=method, model=given))
        assert "model_ignored" in [n.code for n in result.notices]


@pytest.mark.parametrize(("line", "text"), [("gapp: 1.0e-3", "no parameter 'gapp'"), ("gap: -1.0e-3", "backlash.gap")])
def test_an_effect_that_is_none_is_refused_with_the_file(line: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / "model.yaml"
    COBOT_JOINT.write(path)
    path.write_text(path.read_text().replace("effects: {}", f"effects:\n  backlash:\n    {line}"))
    with pytest.raises(ConfigurationError, match=text) as caught:
        given_model({"model": str(path)})
    assert str(path) in str(caught.value)


@pytest.mark.slow
def test_a_joint_that_slides_has_no_first_moments() -> None:
    model = COBOT_JOINT.without(("MX", "MY"))
    recording = virtual_recording(JointModel({**model.parameters, "offset": 3.0}), EXPERIMENT, CHAIN)
    result = identify(recording, IdentifyOptions(sensors="motor"), prismatic=True)
    keys = [p.key for p in result.parameters]
    assert "MX" not in keys
    assert "MY" not in keys
    assert result.parameter("offset").value == pytest.approx(3.0, rel=0.05)
    assert "offset" in GapOptions(prismatic=True).base_catalogue
