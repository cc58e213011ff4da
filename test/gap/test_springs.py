"""Springs that are softer at small torque, relax, or vary with the angle: named; the truth is the virtual joint."""

from dataclasses import replace

import numpy as np
import pytest

from flex_ident.estimation.identification import identify
from flex_ident.gap import GapOptions, explain
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=20.0, sample_rate_hz=500.0, profile="rich")
CHAIN = MeasurementChain.with_bits(17, 20)
SPRINGS = {
    "soft_zone": {"share": 0.4, "deflection": 5e-4},
    "viscoelastic_spring": {"stiffness": 1500.0, "time": 0.02},
}


@pytest.mark.campaign
@pytest.mark.parametrize(("effect", "link"), [("soft_zone", True), ("soft_zone", False), ("viscoelastic_spring", True)])
def test_a_spring_is_named_and_measured(effect: str, link: bool) -> None:
    truth = COBOT_JOINT.with_effect(effect, SPRINGS[effect])
    found = explain(virtual_recording(truth, EXPERIMENT, CHAIN, seed=5, link=link), GapOptions())
    assert [f.effect for f in found.findings] == [effect], found.rejected
    sizes = {p.key: p for p in found.findings[0].parameters}
    for key, size in SPRINGS[effect].items():
        assert sizes[key].value == pytest.approx(size, rel=0.15), key
    assert found.final.parameter("K").value == pytest.approx(COBOT_JOINT.value("K"), rel=0.02)


@pytest.mark.slow
def test_a_spring_that_relaxes_is_not_seen_by_the_motor_alone_and_within_what_is_said() -> None:
    """Motor and link take its loss for their own friction, which is then not identifiable."""
    size = SPRINGS["viscoelastic_spring"]
    truth = COBOT_JOINT.with_effect("viscoelastic_spring", size)
    result = identify(virtual_recording(truth, EXPERIMENT, CHAIN, seed=5, link=False))
    stiffness = result.parameter("K")
    at_the_mode = truth.value("K") + size["stiffness"]  # the branch has no time to relax
    assert abs(stiffness.value - at_the_mode) < 3.0 * stiffness.std
    for key in ("Jm", "JL", "FSm", "FS"):
        assert abs(result.parameter(key).value - truth.value(key)) < 3.0 * result.parameter(key).std, key
    assert not result.parameter("FV").identifiable
    assert {n.subject for n in result.notices if n.code == "loss_unseen"} == {"FV", "FVm"}


@pytest.mark.campaign
@pytest.mark.parametrize("link", [True, False])
def test_a_stiffness_that_varies_with_the_angle_is_named_and_measured(link: bool) -> None:
    """Judged by the stiffness over the range of motion: in a small one its two parts look alike."""
    name, sizes = "position_dependent_stiffness", {"cosine": 300.0, "sine": 900.0}
    truth = COBOT_JOINT.with_effect(name, sizes)
    wide = replace(EXPERIMENT, profile="falling", amplitude=0.3)
    recording = virtual_recording(truth, wide, CHAIN, seed=5, link=link)
    found = explain(recording, GapOptions())
    assert [f.effect for f in found.findings] == [name], found.rejected
    angles = np.quantile(recording.motor_position, [0.02, 0.5, 0.98])

    def stiffness(k: float, cosine: float, sine: float) -> np.ndarray:
        return k + cosine * (np.cos(2.0 * angles) - 1.0) + sine * np.sin(2.0 * angles)

    size = {p.key.rpartition(".")[2]: p.value for p in found.findings[0].parameters}
    known = stiffness(found.final.parameter("K").value, size["cosine"], size["sine"])
    right = stiffness(truth.value("K"), sizes["cosine"], sizes["sine"])
    assert known == pytest.approx(right, rel=0.005)
    assert float(np.ptp(right)) > 0.02 * float(np.mean(right))
