"""The drive follows, the node's steps are the record's, and a recording says what happened."""

import numpy as np
import pytest

from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import (
    COBOT_JOINT,
    JOINTS,
    PERFECT,
    Drive,
    Experiment,
    Instruments,
    Interface,
    MeasurementChain,
    VirtualJoint,
    ample_effort,
    chain_for,
    drive_for,
)
from flex_ident.virtual_joint.drive import drive_cycles
from flex_ident.virtual_joint.run import virtual_motion, virtual_recording, virtual_signals

RIGID = JointModel({"J": 2.0, "FV": 3.0, "FS": 1.0, "MX": 0.2, "MY": 1.0}, joint="rigid")


@pytest.mark.parametrize("name", JOINTS)
def test_a_chirp_to_30_hz_is_followed_within_an_ample_effort(name: str) -> None:
    model = JOINTS[name]
    motion = virtual_motion(model, Experiment(start_frequency_hz=0.05))
    error = motion.motor_position - motion.reference
    assert np.std(error) < 0.15 * np.std(motion.reference)
    spectrum = np.fft.rfft(np.stack((motion.reference, motion.motor_position)))
    frequency = np.fft.rfftfreq(motion.reference.size, 1e-3)
    for low, high in ((0.1, 3.0), (24.0, 29.0)):
        asked, done = spectrum[:, (frequency > low) & (frequency < high)]
        assert abs(np.vdot(asked, done) / np.vdot(asked, asked)) == pytest.approx(1.0, abs=0.3), (low, high)
    assert np.max(np.abs(motion.rows[:, 4])) < 0.7 * ample_effort(model)


def test_an_ample_effort_carries_all_of_the_weight() -> None:
    model = JOINTS["cobot"]
    heavy = model.with_effect("gravity", {"MY": 40.0})
    assert ample_effort(heavy) > ample_effort(model) + 200.0


@pytest.mark.parametrize("rate_hz", [200.0, 350.87, 1000.0])
@pytest.mark.parametrize("interface", ["position", "velocity", "effort"])
@pytest.mark.parametrize("model", [COBOT_JOINT, RIGID], ids=["flexible", "rigid"])
def test_steps_of_the_joint_are_the_run(model: JointModel, interface: Interface, rate_hz: float) -> None:
    model = model.with_effect("time_delay", {"delay": 0.0013}).with_effect("encoder_skew", {"skew": -0.0007})
    drive = drive_for(model, effort_limit=25.0, interface=interface)
    commands = 0.2 * np.sin(np.arange(2000) / rate_hz * 8.0) + 0.3
    joint = VirtualJoint(model, rate_hz=rate_hz, drive=drive, instruments=Instruments(0.0, 0.0), start=commands[0])
    steps = [joint.step(command) for command in commands]
    experiment = Experiment(sample_rate_hz=rate_hz, start=commands[0])
    motion = virtual_motion(model, experiment, drive=drive, reference=commands)
    if interface != "position":  # the run's drive was commanded nothing before
        assert steps[0].motor_position == pytest.approx(commands[0], abs=1e-3)
    inner = steps[20:]
    times = np.array([m.time for m in inner])
    expected = motion.at(times, torque_delay=0.0013, link_skew=-0.0007)
    got = np.array([(m.motor_position, m.link_position, m.motor_torque) for m in inner])
    assert got == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert np.diff(times) == pytest.approx(1.0 / rate_hz)


def test_the_effort_limit_holds_and_the_integrator_does_not_wind_up() -> None:
    joint = VirtualJoint(COBOT_JOINT, drive=drive_for(COBOT_JOINT, effort_limit=12.0))
    moving = [joint.step(1.0) for _ in range(4000)]
    assert max(abs(m.motor_torque) for m in moving) == 12.0
    back = [joint.step(0.0) for _ in range(6000)]
    assert abs(back[-1].motor_position) < 2e-3
    assert min(m.motor_position for m in back) > -0.05


def test_a_command_that_is_no_number_changes_nothing() -> None:
    joint = VirtualJoint(COBOT_JOINT, start=0.2)
    assert all(abs(joint.step(float("nan")).motor_position - 0.2) < 1e-5 for _ in range(500))


def test_an_effort_drive_holds_the_joint_until_it_is_commanded() -> None:
    joint = VirtualJoint(COBOT_JOINT, drive=drive_for(COBOT_JOINT, interface="effort"), start=0.4)
    assert joint.command == pytest.approx(9.81 * (0.5 * np.cos(0.4) + 3.0 * np.sin(0.4)), rel=1e-2)
    assert abs([joint.step(joint.command) for _ in range(500)][-1].motor_position - 0.4) < 1e-5


@pytest.mark.parametrize(("rate_hz", "cycles"), [(100.0, 20), (350.87, 6), (1000.0, 2), (4000.0, 2)])
def test_the_drive_runs_at_2_khz_or_more(rate_hz: float, cycles: int) -> None:
    assert drive_cycles(rate_hz) == cycles


def test_the_recorded_torque_is_the_mean_around_the_instant() -> None:
    motion = virtual_motion(COBOT_JOINT, Experiment(duration_s=4.0, sample_rate_hz=200.0))
    held = motion.rows[:, 4]
    for k in (3, 100, 600):
        assert motion.torque[k] == pytest.approx(np.mean(held[10 * k - 5 : 10 * k + 5]), rel=1e-12)


def test_encoders_have_steps_stamps_are_true_and_messages_get_lost() -> None:
    chain = MeasurementChain(1e-4, 2e-4, torque_noise=0.02, jitter=0.1, lost=0.03)
    motion = virtual_motion(COBOT_JOINT)
    signals = {s.role: s for s in virtual_signals(COBOT_JOINT, None, chain, seed=3)}
    motor = signals["motor_position"]
    assert motor.time.size == pytest.approx(0.97 * 60000, rel=0.01)
    assert np.std(motor.time - np.round(motor.time * 1000.0) / 1000.0) == pytest.approx(1e-4, rel=0.05)
    true = motion.at(motor.time)
    steps = np.diff(np.unique(motor.values)) / 1e-4
    assert np.max(np.abs(steps - np.round(steps))) < 1e-6
    assert np.max(np.abs(motor.values - true[:, 0])) < 0.5001e-4
    assert np.max(np.abs(signals["link_position"].values - true[:, 1])) < 1.0001e-4
    noise = signals["motor_torque"].values - true[:, 2]
    assert np.std(noise) == pytest.approx(0.02 * np.std(true[:, 2]), rel=0.02)


def test_seeds_repeat_and_differ() -> None:
    experiment = Experiment(duration_s=5.0, end_frequency_hz=10.0)
    first, again, other = (
        virtual_recording(COBOT_JOINT, experiment, chain_for("medium"), seed=s).motor_torque for s in (1, 1, 2)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_perfect_chain_records_the_motion_itself() -> None:
    recording = virtual_recording(COBOT_JOINT, Experiment(duration_s=5.0), PERFECT)
    motion = virtual_motion(COBOT_JOINT, Experiment(duration_s=5.0))
    n = recording.time.size
    assert recording.link_position is not None
    assert recording.motor_position == pytest.approx(motion.motor_position[:n], abs=1e-12)
    assert recording.link_position == pytest.approx(motion.link_position[:n], abs=1e-12)
    assert not recording.notices


@pytest.mark.parametrize("profile", ["falling", "constant_position", "rich"])
@pytest.mark.parametrize("sweep", ["logarithmic", "linear"])
def test_experiments_sweep_what_they_say(profile: str, sweep: str) -> None:
    experiment = Experiment(0.5, 20.0, 30.0, 0.1, sweep=sweep, profile=profile, repeats=2, start=0.3)  # type: ignore[arg-type]
    reference = experiment.reference()
    assert reference.size == 30000
    assert reference[:15000] == pytest.approx(reference[15000:])
    swing = np.max(np.abs(reference - 0.3))
    assert swing == pytest.approx(0.5 if profile == "rich" else 0.1, rel=0.06)
    assert abs(reference[0] - 0.3) < 1e-12
    late = reference[13500:13900] if profile != "rich" else reference[9000:9300]
    crossings = np.count_nonzero(np.diff(np.sign(late - 0.3)))
    frequency = crossings / 2.0 / (late.size / 1000.0)
    if profile != "rich":
        assert frequency == pytest.approx(20.0 * 40.0**-0.09 if sweep == "logarithmic" else 18.2, rel=0.12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: MeasurementChain(lost=1.0), "lost is 1.0"),
        (lambda: MeasurementChain(jitter=-0.1), "jitter is -0.1"),
        (lambda: Experiment(sweep="cubic"), "sweep is 'cubic'"),
        (lambda: Experiment(duration_s=0.0), "duration_s is 0.0"),
        (lambda: Drive(1.0, 1.0, 1.0, effort_limit=0.0), "effort_limit of the drive is 0.0"),
        (lambda: chain_for("none"), "measurement chain 'none'"),
        (lambda: VirtualJoint(COBOT_JOINT, rate_hz=0.0), "rate is 0.0 Hz"),
    ],
)
def test_what_makes_no_sense_is_refused(make: object, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        make()  # type: ignore[operator]
