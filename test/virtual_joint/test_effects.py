"""Each effect of the catalogue does what the table in ARCHITECTURE.md says, and nothing else is known to the plant."""

from collections.abc import Callable

import numpy as np
import pytest

from flex_ident.effects.catalogue import CATALOGUE
from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import PERFECT, Drive, Experiment, TrueMotion, drive_for
from flex_ident.virtual_joint.physics import EFFECTS, plant_values
from flex_ident.virtual_joint.plant import state_at_rest, stepped
from flex_ident.virtual_joint.run import virtual_motion, virtual_signals

LEVEL = JointModel({"Jm": 1.0, "K": 1e4, "JL": 1.0, "FVm": 8.0, "FSm": 4.0, "FV": 2.0, "FS": 1.0}, joint="level")
"""Without gravity: at constant speed the motor's torque is friction."""
LINK = 2.0
CLAMPED = JointModel({"Jm": 0.5, "K": 1e4, "JL": 1.0, "FVm": 5.0, "FS": 1e6}, joint="clamped")
"""The link never moves: the motor's torque, moved slowly, is the spring's."""


def at_speed(model: JointModel, velocity: float, seconds: float = 6.0) -> TrueMotion:
    """The joint at a constant speed."""
    reference = np.full(round(seconds * 1000), velocity)
    return virtual_motion(model, Experiment(), drive=drive_for(model, interface="velocity"), reference=reference)


def stiff(model: JointModel) -> Drive:
    """A drive that follows slow commands exactly."""
    return Drive(60.0, 400.0, 2e4, inertia=model.value("Jm"))


def slowly(model: JointModel, amplitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Deflection and spring torque (n,) of the clamped joint, its motor swung twice at 0.25 Hz."""
    t = np.arange(8000) / 1000.0
    motion = virtual_motion(model, drive=stiff(model), reference=amplitude * np.sin(0.5 * np.pi * t))
    torque = motion.torque - 5.0 * motion.motor_velocity
    keep = slice(2000, None)
    return motion.motor_position[keep], torque[keep]


def test_the_plant_knows_every_parameter_of_the_catalogue() -> None:
    catalogue = {f"{effect.name}.{p.name}" for effect in CATALOGUE.values() for p in effect.parameters}
    missing = catalogue - set(EFFECTS)
    assert not missing
    with pytest.raises(ConfigurationError, match=r"no effect parameter 'lugre\.stiffness'"):
        plant_values(LEVEL.with_effect("lugre", {"stiffness": 1.0}))


@pytest.mark.parametrize(
    ("effect", "parameters", "extra"),
    [
        ("stribeck_friction", {"amplitude": 3.0, "velocity": 0.4}, lambda v: 3 * np.exp(-v * v / 0.16) * np.sign(v)),
        ("stribeck_friction", {"amplitude_link": 3.0, "velocity_link": 0.4},
         lambda v: 3 * np.exp(-v * v / 0.16) * np.sign(v)),
        ("presliding_friction", {"deflection": 1e-3, "amplitude": 3.0, "velocity": 0.4},
         lambda v: 3 * np.exp(-v * v / 0.16) * np.sign(v)),
        ("torque_offset", {"offset": 2.5}, lambda v: 2.5),
        ("viscous_asymmetry", {"coefficient": 1.5}, lambda v: 1.5 * abs(v)),
        ("viscous_asymmetry", {"coefficient_link": 1.5}, lambda v: 1.5 * abs(v)),
        ("viscous_nonlinearity", {"coefficient": 1.5}, lambda v: 1.5 * v * abs(v)),
        ("viscous_nonlinearity", {"coefficient_link": 1.5}, lambda v: 1.5 * v * abs(v)),
        ("load_dependent_friction", {"coefficient": 0.2}, lambda v: 0.2 * (2.0 * v + np.sign(v))),
        ("friction_drift", {"rate": 0.05}, lambda v: 0.05 * 5.0 * (10.0 * v + 5.0 * np.sign(v))),
        ("friction_drift", {"rate_motor": 0.05}, lambda v: 0.05 * 5.0 * (8.0 * v + 4.0 * np.sign(v))),
    ],
)  # fmt: skip
@pytest.mark.parametrize("velocity", [0.3, -0.7])
def test_friction_at_constant_speed(
    effect: str, parameters: dict[str, float], extra: Callable[[float], float], velocity: float
) -> None:
    motion = at_speed(LEVEL.with_effect(effect, parameters), velocity)
    friction = 10.0 * velocity + 5.0 * np.sign(velocity)
    assert motion.torque[5000] == pytest.approx(friction + extra(velocity), rel=2e-3)


def test_bristles_bend_before_they_slide() -> None:
    model = JointModel({"Jm": 1.0, "K": 1e4, "JL": 1.0, "FSm": 4.0}).with_effect(
        "presliding_friction", {"deflection": 1e-3}
    )
    p = plant_values(model)
    state = state_at_rest(p, 0.0, 0.0)
    for k in range(60000):
        stepped(p, state, min(2.0, 4e-5 * k), 1e-4, 1.0)  # slowly: a loop on the way would leave a way of its own
        state[[1, 3]] *= 0.99  # damping
    assert state[0] == pytest.approx(-1e-3 * np.log(0.5), rel=0.05)
    for _ in range(40000):
        stepped(p, state, 0.0, 1e-4, 1.0)
        state[[1, 3]] *= 0.99
    assert 0.0 < state[0] < 5e-4  # it springs back, not all the way


def test_ripple_is_a_line_over_motor_angle() -> None:
    model = LEVEL.with_effect("torque_ripple", {"amplitude": 0.5, "cycles_per_turn": 20.0, "phase": 0.4})
    t = np.arange(12000) / 1000.0
    motion = virtual_motion(model, drive=Drive(100.0, 2000.0, 1e4), reference=0.2 * t)
    tail = slice(4000, None)
    q, torque = motion.motor_position[tail], motion.torque[tail]
    columns = np.column_stack((np.sin(20 * q + 0.4), np.cos(20 * q + 0.4), np.ones(q.size)))
    fit = np.linalg.lstsq(columns, torque, rcond=None)[0]
    assert fit == pytest.approx([0.5, 0.0, 7.0], abs=0.03)


def test_ripple_may_have_a_further_harmonic() -> None:
    ripple = {"amplitude": 0.5, "cycles_per_turn": 20.0, "phase": 0.4}
    ripple |= {"amplitude_3": 0.3, "cycles_per_turn_3": 33.0, "phase_3": 1.0}
    t = np.arange(12000) / 1000.0
    motion = virtual_motion(
        LEVEL.with_effect("torque_ripple", ripple), drive=Drive(100.0, 2000.0, 1e4), reference=0.2 * t
    )
    q, torque = motion.motor_position[4000:], motion.torque[4000:]
    columns = np.column_stack((np.sin(20 * q + 0.4), np.sin(33 * q + 1.0), np.ones(q.size)))
    fit = np.linalg.lstsq(columns, torque, rcond=None)[0]
    assert fit == pytest.approx([0.5, 0.3, 7.0], abs=0.03)


def test_kinematic_error_moves_the_link_against_the_motor() -> None:
    error = {"amplitude": 2e-4, "cycles_per_turn": 20.0, "phase": 0.4}
    motion = at_speed(LEVEL.with_effect("kinematic_error", error), 0.2, 12.0)
    q, link = motion.motor_position[4000:], motion.link_position[4000:]
    columns = np.column_stack((np.sin(20 * q + 0.4), np.cos(20 * q + 0.4), np.ones(q.size)))
    fit = np.linalg.lstsq(columns, link - q, rcond=None)[0]
    assert fit[0] == pytest.approx(2e-4, rel=0.03)
    assert fit[2] == pytest.approx(-1.4 / 1e4, rel=0.05)


def test_nonlinear_stiffness_hardens() -> None:
    d, torque = slowly(CLAMPED.with_effect("nonlinear_stiffness", {"cubic": 5e7}), 0.01)
    assert np.max(np.abs(torque - 1e4 * d - 5e7 * d**3)) < 0.01 * np.max(torque)


def test_backlash_is_a_dead_band() -> None:
    d, torque = slowly(CLAMPED.with_effect("backlash", {"gap": 0.004}), 0.01)
    engaged = np.sign(d) * np.maximum(np.abs(d) - 0.002, 0.0)
    assert np.max(np.abs(torque - 1e4 * engaged)) < 0.02 * np.max(torque)


def test_a_part_that_relaxes_stiffens_the_spring_for_a_while() -> None:
    model = CLAMPED.with_effect("viscoelastic_spring", {"stiffness": 4e3, "time": 0.2})
    reference = np.where(np.arange(4000) < 1000, 0.0, 0.01)
    motion = virtual_motion(model, drive=stiff(model), reference=reference)
    before, after = motion.torque[1150:1160].mean(), motion.torque[3900:].mean()
    assert after == pytest.approx(100.0, rel=0.01)
    assert before - after == pytest.approx(40.0 * np.exp(-0.155 / 0.2), rel=0.15)


def test_a_soft_zone_leaves_less_of_the_stiffness_at_small_torque() -> None:
    d, torque = slowly(CLAMPED.with_effect("soft_zone", {"share": 0.5, "deflection": 0.002}), 0.01)
    assert np.max(np.abs(torque - 1e4 * (d - 0.5 * d / np.sqrt(1.0 + (d / 0.002) ** 2)))) < 0.02 * np.max(torque)


def test_hysteresis_opens_a_loop_that_is_the_same_at_any_speed() -> None:
    model = CLAMPED.with_effect("hysteresis", {"torque": 8.0, "deflection": 5e-4})
    d, torque = slowly(model, 0.01)
    part = torque - 1e4 * d
    rising = np.gradient(d) > 0
    middle = np.abs(d) < 1e-3
    assert np.median(part[middle & rising]) == pytest.approx(8.0, rel=0.03)
    assert np.median(part[middle & ~rising]) == pytest.approx(-8.0, rel=0.03)


def test_joint_damping_lets_the_oscillation_decay() -> None:
    model = JointModel({"Jm": 1.0, "K": 1e4, "JL": 0.5}).with_effect("joint_damping", {"damping": 2.0})
    p = plant_values(model)
    state = state_at_rest(p, 0.0, 0.0)
    state[0] = 0.01
    energy = []
    for _ in range(5000):
        energy.append(0.5 * state[1] ** 2 + 0.25 * state[3] ** 2 + 5e3 * (state[0] - state[2]) ** 2)
        stepped(p, state, 0.0, 1e-4, 1.0)
    assert np.log(energy[0] / energy[-1]) / 0.4999 == pytest.approx(2.0 * (1 + 2), rel=0.02)


def test_second_mode_rings_where_the_eigenvalues_say() -> None:
    second = {"inertia": 0.3, "stiffness": 3000.0, "damping": 0.0}
    model = JointModel({"Jm": 1.0, "K": 1e4, "JL": 0.5}).with_effect("second_mode", second)
    stiffness = np.array([[1e4, -1e4, 0], [-1e4, 1.3e4, -3000], [0, -3000, 3000.0]])
    expected = np.sqrt(np.linalg.eigvals(stiffness / np.array([[1.0], [0.5], [0.3]])).real.clip(0)) / (2 * np.pi)
    p = plant_values(model)
    state = state_at_rest(p, 0.0, 0.0)
    state[1] = 0.1
    motor = []
    for _ in range(40000):
        motor.append(state[1])
        stepped(p, state, 0.0, 1e-4, 1.0)
    spectrum = np.abs(np.fft.rfft((np.array(motor) - np.mean(motor)) * np.hanning(40000)))
    peaks = [k for k in range(2, 300) if spectrum[k] > spectrum[k - 1] and spectrum[k] > spectrum[k + 1]]
    found = sorted(sorted(peaks, key=lambda k: -spectrum[k])[:2])
    assert np.array(found) * 0.25 == pytest.approx(np.sort(expected)[1:], abs=0.25)


def test_saturation_delivers_less_than_is_recorded() -> None:
    model = LEVEL.with_effect("saturation", {"limit": 7.0})
    motion = virtual_motion(model, drive=drive_for(model, interface="effort"), reference=np.full(4000, 20.0))
    assert motion.torque[-1] == 20.0
    limited = virtual_motion(LEVEL, drive=drive_for(LEVEL, interface="effort"), reference=np.full(4000, 7.0))
    assert motion.motor_position == pytest.approx(limited.motor_position, abs=1e-9)


def test_iron_and_speed_take_their_share_of_the_torque() -> None:
    hard = drive_for(LEVEL, interface="effort")
    iron = virtual_motion(
        LEVEL.with_effect("iron_saturation", {"loss": 1e-3}), drive=hard, reference=np.full(4000, 20.0)
    )
    assert iron.torque[-1] == 20.0
    less = virtual_motion(LEVEL, drive=hard, reference=np.full(4000, 20.0 / 1.4))
    assert iron.motor_position == pytest.approx(less.motor_position, abs=1e-9)
    droop = virtual_motion(LEVEL.with_effect("torque_droop", {"loss": 0.1}), drive=hard, reference=np.full(20000, 20.0))
    speed = droop.motor_velocity[-1]
    assert 20.0 / (1.0 + 0.1 * speed**2) == pytest.approx(10.0 * speed + 5.0, rel=1e-3)  # what friction takes


def test_a_gain_that_drifts_is_read_and_not_felt() -> None:
    reference, drive = np.full(4000, 20.0), drive_for(LEVEL, interface="effort")
    plain = virtual_motion(LEVEL, drive=drive, reference=reference)
    warm = virtual_motion(LEVEL.with_effect("gain_drift", {"rate": 0.02}), drive=drive, reference=reference)
    assert np.array_equal(warm.motor_position, plain.motor_position)
    gain = warm.torque / plain.torque
    assert gain[0] == 1.0
    assert gain[-1] == pytest.approx(1.0 + 0.02 * plain.time[-1], rel=1e-4)


@pytest.mark.parametrize("shift", [0.0023, -0.0017])
@pytest.mark.parametrize(
    ("effect", "key", "role"), [("time_delay", "delay", "motor_torque"), ("encoder_skew", "skew", "link_position")]
)
def test_a_late_channel_shows_what_was_before(effect: str, key: str, role: str, shift: float) -> None:
    experiment = Experiment(duration_s=8.0, end_frequency_hz=10.0)
    plain = {s.role: s for s in virtual_signals(LEVEL, experiment, PERFECT)}
    late = {s.role: s for s in virtual_signals(LEVEL.with_effect(effect, {key: shift}), experiment, PERFECT)}
    for name, signal in plain.items():
        values = late[name].values
        if name != role:
            assert np.array_equal(values, signal.values)
            continue
        expected = np.interp(signal.time - shift, signal.time, signal.values)
        assert np.std((values - expected)[10:-10]) < 0.05 * np.std(values - signal.values)
