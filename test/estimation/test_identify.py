"""Maximum likelihood on the virtual joint, whose plant, integrator and friction are not the estimator's."""

import math
from dataclasses import replace

import numpy as np
import pytest

from flex_ident.errors import ExcitationError, UsageError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import JointModel
from flex_ident.recording import Recording
from flex_ident.recording.alignment import aligned_recording
from flex_ident.virtual_joint import COBOT_JOINT, JOINTS, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording, virtual_signals

EXPERIMENT = Experiment(duration_s=30.0)
ESSENTIAL = ("Jm", "K", "JL")


def chain(bits: int) -> MeasurementChain:
    return MeasurementChain.with_bits(bits, bits, torque_noise=0.01, jitter=0.05, lost=0.002)


@pytest.fixture(
    scope="module",
    params=[pytest.param(n, marks=pytest.mark.campaign if n == "series_elastic" else ()) for n in JOINTS],
)
def joint_and_recording(request: pytest.FixtureRequest) -> tuple[JointModel, Recording]:
    model = JOINTS[request.param]
    bits = 17 if request.param == "cobot" else 20
    return model, virtual_recording(model, EXPERIMENT, chain(bits), seed=5)


@pytest.mark.slow
@pytest.mark.parametrize("sensors", [pytest.param("motor", marks=pytest.mark.campaign), "motor+link"])
def test_recovers_the_joint_within_its_uncertainty(
    joint_and_recording: tuple[JointModel, Recording], sensors: str
) -> None:
    model, recording = joint_and_recording
    # So light a link may as well be one whose controller adds the gravity: from the motor alone it must be told.
    kind = "motor" if model is JOINTS["series_elastic"] and sensors == "motor" else "auto"
    result = identify(recording, IdentifyOptions(sensors=sensors, effort_kind=kind))
    assert result.verdict == "trusted"
    for p in result.parameters:
        if p.identifiable:
            assert abs(p.value - model.value(p.key)) < 4.0 * p.std, p
    for key in ESSENTIAL:
        assert result.parameter(key).value == pytest.approx(model.value(key), rel=0.01)
        assert result.parameter(key).relative_std_percent < 1.0


@pytest.mark.campaign
@pytest.mark.parametrize("factor", [3.0, 1.0 / 3.0])
def test_a_first_guess_a_factor_of_three_off_converges(factor: float) -> None:
    recording = virtual_recording(COBOT_JOINT, EXPERIMENT, chain(20), seed=1)
    values = dict(COBOT_JOINT.parameters)
    guess = JointModel({**values, "K": values["K"] * factor, "JL": values["JL"] / factor, "Jm": values["Jm"] * factor})
    result = identify(recording, IdentifyOptions(sensors="motor", model=guess))
    for key in ESSENTIAL:
        assert result.parameter(key).value == pytest.approx(values[key], rel=0.01)


def test_paper_method_on_both_positions() -> None:
    recording = virtual_recording(JOINTS["paper"], EXPERIMENT, chain(20), seed=2)
    result = identify(recording, IdentifyOptions(sensors="motor+link", method="paper"))
    for key in ESSENTIAL:
        assert result.parameter(key).value == pytest.approx(JOINTS["paper"].value(key), rel=0.02)


def test_paper_method_on_the_motor_alone_says_that_it_is_poor() -> None:
    recording = virtual_recording(JOINTS["paper"], EXPERIMENT, chain(20), seed=2)
    result = identify(recording, IdentifyOptions(sensors="motor", method="paper", first_mode_hz=3.9))
    assert result.verdict != "trusted"
    assert result.derived["x5_sigmas"] > 3.0
    assert {n.code for n in result.notices} & {"x5_inconsistent", "simplified_model"}
    assert result.parameter("K").value < 0.8 * JOINTS["paper"].value("K")


@pytest.mark.campaign
def test_a_sweep_below_the_mode_is_not_trusted_for_stiffness() -> None:
    slow = Experiment(start_frequency_hz=0.05, end_frequency_hz=1.0, duration_s=30.0, sample_rate_hz=500.0)
    recording = virtual_recording(COBOT_JOINT, slow, chain(20), seed=3)
    result = identify(recording, IdentifyOptions(sensors="motor"))
    assert "taken_as_rigid" in [n.code for n in result.notices]
    whole = COBOT_JOINT.value("Jm") + COBOT_JOINT.value("JL")
    assert abs(result.parameter("J").value - whole) < 4.0 * result.parameter("J").std
    assert "K" not in [p.key for p in result.parameters]
    given = identify(recording, IdentifyOptions(sensors="motor", first_mode_hz=0.9))
    assert given.verdict == "rejected"


def test_four_derivatives_at_a_low_rate_are_refused_with_the_rate() -> None:
    recording = virtual_recording(COBOT_JOINT, Experiment(duration_s=20.0, sample_rate_hz=200.0), chain(20))
    with pytest.raises(ExcitationError, match=r"eq\. 29"):
        identify(recording, IdentifyOptions(sensors="motor", method="paper", first_mode_hz=15.0))


@pytest.mark.campaign
def test_gaps_in_the_recording_do_no_harm() -> None:
    signals = virtual_signals(COBOT_JOINT, EXPERIMENT, chain(20), seed=4, link=False)
    broken = []
    for signal in signals:
        kept = np.ones(signal.time.size, bool)
        for start in (5000, 12000, 20000):
            kept[start : start + 150] = False
        broken.append(replace(signal, time=signal.time[kept], values=signal.values[kept]))
    recording = aligned_recording(broken, joint="cobot", notices=[], path="", sha256="")
    assert recording.measured is not None
    assert not recording.measured.all()
    result = identify(recording, IdentifyOptions(sensors="motor"))
    for key in ESSENTIAL:
        p = result.parameter(key)
        assert p.value == pytest.approx(COBOT_JOINT.value(key), rel=0.02)
        assert abs(p.value - COBOT_JOINT.value(key)) < 4.0 * p.std


@pytest.mark.campaign
def test_cutoff_sweep_is_level_on_a_model_that_holds() -> None:
    recording = virtual_recording(COBOT_JOINT, EXPERIMENT, chain(20), seed=6)
    result = identify(recording, IdentifyOptions(cutoff_sweep=True))
    assert result.cutoff_sweep is not None
    assert len(result.cutoff_sweep.cutoff_rad_s) >= 4
    assert not [n for n in result.notices if n.code == "cutoff_dependent"]
    assert np.ptp(result.cutoff_sweep.values["K"]) < 0.03 * 1e4


@pytest.mark.parametrize("wrong", [{"sensors": "camera"}, {"method": "guess"}, {"first_mode_hz": math.nan}])
def test_options_that_make_no_sense_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(UsageError):
        IdentifyOptions(**wrong)  # type: ignore[arg-type]
