"""What `identify` refuses to trust: rigid machines taken for flexible ones, wrong signs, wrong units."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags.reading import read_recording
from flex_ident.errors import ExcitationError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap import explain
from flex_ident.notices import Code, Notice
from flex_ident.recording import Recording
from flex_ident.recording.magnitudes import magnitude_notices
from flex_ident.report.advice import first_thing
from flex_ident.report.sentences import sentence
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

pytestmark = pytest.mark.slow
EMPS = Path(__file__).resolve().parents[3] / "shared" / "real" / "emps_train"


@pytest.fixture(scope="module")
def cobot() -> Recording:
    return virtual_recording(COBOT_JOINT, Experiment(duration_s=15.0), MeasurementChain.with_bits(20, 20), seed=1)


@pytest.mark.skipif(not EMPS.exists(), reason="needs ../shared/real/emps_train")
def test_rigid_machine_is_taken_as_rigid() -> None:
    result = identify(read_recording(EMPS))
    assert result.notices[0].code == "taken_as_rigid"
    assert "a rigid joint explains it as well (3.3 against 2." in sentence(result.notices[0])
    assert result.parameter("J").value == pytest.approx(95.1, rel=0.02)
    assert "K" not in result.model.parameters


def test_rigid_machine_on_which_the_spring_runs_away_is_taken_as_rigid() -> None:
    t = np.arange(0.0, 20.0, 2e-3)
    phase, omega = 2 * np.pi * (0.2 * t + 0.1 * t**2), 2 * np.pi * (0.2 + 0.2 * t)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * (2 * np.pi * 0.2 * np.cos(phase) - omega**2 * np.sin(phase))
    noise = np.random.default_rng(0).normal(0.0, 0.3, t.size)
    torque = 2.0 * a + 3.0 * v + np.sign(v) + 9.81 * (3.0 * np.cos(q) + np.sin(q)) + noise
    recording = Recording("j", 500.0, q, torque)
    result = identify(recording)
    assert result.notices[0].code == "taken_as_rigid"
    assert result.parameter("J").value == pytest.approx(2.0, rel=0.02)
    found = explain(recording)
    assert found.notices[0].code == "taken_as_rigid"
    assert found.final.parameter("J").value == pytest.approx(result.parameter("J").value, rel=1e-6)


def test_flexible_joint_is_left_in_peace(cobot: Recording) -> None:
    result = identify(cobot, IdentifyOptions(sensors="motor"))
    assert result.verdict == "trusted"


@pytest.mark.parametrize("end_frequency_hz", [20.0, pytest.param(30.0, marks=pytest.mark.campaign)])
def test_what_was_commanded_slowly_is_doubtful_and_its_error_bar_says_so(end_frequency_hz: float) -> None:
    experiment = Experiment(duration_s=40.0, sample_rate_hz=100.0, end_frequency_hz=end_frequency_hz)
    result = identify(
        virtual_recording(COBOT_JOINT, experiment, MeasurementChain(torque_noise=0.01), seed=3, link=False)
    )
    assert result.verdict == "doubtful"
    assert "sampled_slowly" in [n.code for n in result.notices]
    for key in ("Jm", "K", "JL"):
        parameter = result.parameter(key)
        assert abs(parameter.value - COBOT_JOINT.value(key)) < 2.0 * parameter.std
        assert parameter.relative_std_percent < 10.0


@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
def test_reversed_effort_is_named(cobot: Recording, sensors: str) -> None:
    turned = replace(cobot, motor_torque=-cobot.motor_torque)
    with pytest.raises(ExcitationError, match=r"effort seems reversed: .* --effort-scale -1"):
        identify(turned, IdentifyOptions(sensors=sensors))
    result = identify(turned, IdentifyOptions(sensors=sensors, method="weighted"))
    assert result.verdict == "rejected"
    assert result.notices[0].code == "effort_reversed"


def swinging(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    """Position, velocity and acceleration (6000,) at 200 Hz of a random motion up to about 8 Hz."""
    random = np.random.default_rng(seed)
    t, q, v, a = np.arange(6000) / 200.0, np.zeros(6000), np.zeros(6000), np.zeros(6000)
    for frequency in random.uniform(0.1, 8.0, 40):
        omega, phase = 2.0 * np.pi * frequency, random.uniform(0.0, 2.0 * np.pi)
        size = 0.3 / (1.0 + frequency**2)
        q += size * np.sin(omega * t + phase)
        v += size * omega * np.cos(omega * t + phase)
        a -= size * omega**2 * np.sin(omega * t + phase)
    return q, v, a


@pytest.mark.parametrize("seed", range(3))
def test_an_effort_recorded_late_is_named(seed: int) -> None:
    q, v, a = swinging(seed)
    torque = 0.004 * a + 0.3 * v + 0.05 * np.tanh(v / 0.01)
    noise = np.random.default_rng(seed).normal(0.0, 0.02, q.size)
    recording = Recording("motor", 200.0, q, np.roll(torque, 4) + noise)
    with pytest.raises(ExcitationError, match="recorded about 20 ms late against the position") as caught:
        identify(recording, IdentifyOptions(rigid=True))
    assert "reversed" not in str(caught.value)


@pytest.mark.parametrize("rigid", [False, True])
def test_an_effort_that_drives_the_joint_is_not_reversed(rigid: bool) -> None:
    """Friction loads the motor, other joints the link: the inertia comes out negative, and the sign is right."""
    q, v, a = swinging(5)
    torque = 3.0 * v + 2.0 * np.tanh(v / 0.01) - 0.02 * a
    moved = Notice(Code.OTHER_JOINTS_MOVE, "", {"count": 1}, {"joints": "elbow"})
    noise = np.random.default_rng(5).normal(0.0, 0.05, q.size)
    recording = Recording("wrist", 200.0, q, torque + noise, notices=(moved,))
    with pytest.raises(ExcitationError, match="other joints that move load this one"):
        identify(recording, IdentifyOptions(rigid=rigid))
    with pytest.raises(ExcitationError, match="effort seems reversed"):
        identify(replace(recording, motor_torque=-3.0 * v - 0.5 * a), IdentifyOptions(rigid=rigid))


def test_an_effort_that_brakes_a_joint_which_others_load_is_reversed() -> None:
    """No fit tells: only the work does. Nothing is said of the kind of an effort that no model explains."""
    q, v, a = swinging(6)
    other, _, pull = swinging(7)
    moved = Notice(Code.OTHER_JOINTS_MOVE, "", {"count": 1}, {"joints": "elbow"})
    torque = 6.0 * v + 0.02 * a + 3.0 * np.tanh(v / 0.01) + 4.0 * np.cos(q + other) + 0.3 * pull
    recording = Recording("shoulder", 200.0, q, torque, notices=(moved,))
    assert "reversed" not in what_is_said(recording)
    assert "seems reversed" in what_is_said(replace(recording, motor_torque=-torque))


def what_is_said(recording: Recording) -> str:
    """The error, or what a result that is not trusted is told to do first."""
    try:
        result = identify(recording, IdentifyOptions(rigid=True))
    except ExcitationError as error:
        return str(error)
    assert result.verdict != "trusted"
    return first_thing(result) or ""


@pytest.mark.parametrize(
    ("case", "verdict"), [pytest.param("fast", "trusted", marks=pytest.mark.campaign), ("slow", "doubtful")]
)
def test_an_effort_that_was_measured_slowly_is_not_trusted(cobot: Recording, case: str, verdict: str) -> None:
    numbers = {"stamped_hz": 500.0, "measured_hz": 50.0, "count": 9.0, "total": 10.0}
    said = Notice(Code.HELD_SAMPLES, "/joint_states:a.effort", numbers, {"case": case})
    result = identify(replace(cobot, notices=(said,)), IdentifyOptions(cutoff_sweep=False))
    assert result.verdict == verdict
    assert ((first_thing(result) or "").startswith("/joint_states:a.effort is stamped at 500 Hz")) == (case == "slow")


@pytest.mark.campaign
def test_degrees_are_not_trusted(cobot: Recording) -> None:
    degrees = replace(cobot, motor_position=np.degrees(cobot.motor_position), link_position=None)
    degrees = replace(degrees, notices=magnitude_notices(degrees))
    assert [n.code for n in degrees.notices] == ["position_not_si"]
    result = identify(degrees)
    assert result.verdict != "trusted"


def test_slow_is_not_called_short(cobot: Recording) -> None:
    step = round(cobot.sample_rate_hz / 5.0)
    slow = Recording("j", 5.0, cobot.motor_position[::step], cobot.motor_torque[::step])
    with pytest.raises(ExcitationError, match=r"s at 5 Hz\).*: record at 100 Hz or more"):
        identify(replace(slow))
