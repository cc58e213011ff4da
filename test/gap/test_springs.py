"""Springs that are softer at small torque, or relax: named and measured; the truth is the virtual joint, not ours."""

import pytest

from flex_ident.gap import GapOptions, explain
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain, virtual_recording

EXPERIMENT = Experiment(duration_s=20.0, sample_rate_hz=500.0, profile="rich")
CHAIN = MeasurementChain.with_bits(17, 20)
SPRINGS = {
    "soft_zone": {"share": 0.4, "deflection": 5e-4},
    "viscoelastic_spring": {"stiffness": 1500.0, "time": 0.02},
}


@pytest.mark.slow
@pytest.mark.parametrize("effect", list(SPRINGS))
@pytest.mark.parametrize("link", [True, pytest.param(False, marks=pytest.mark.campaign)])
def test_a_spring_is_named_and_measured(effect: str, link: bool) -> None:
    truth = COBOT_JOINT.with_effect(effect, SPRINGS[effect])
    found = explain(virtual_recording(truth, EXPERIMENT, CHAIN, seed=5, link=link), GapOptions())
    assert [f.effect for f in found.findings] == [effect], found.rejected
    sizes = {p.key: p for p in found.findings[0].parameters}
    for key, size in SPRINGS[effect].items():
        assert sizes[key].value == pytest.approx(size, rel=0.15), key
    assert found.final.parameter("K").value == pytest.approx(COBOT_JOINT.value("K"), rel=0.02)
