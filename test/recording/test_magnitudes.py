"""Units that cannot be right are named; every joint that can exist is left in peace."""

import numpy as np
import pytest

from flex_ident.recording import Floats, Recording
from flex_ident.recording.magnitudes import magnitude_notices

RATE = 500.0
TIME = np.arange(int(40 * RATE)) / RATE


def chirp(low_hz: float, high_hz: float, *, amplitude: float = 0.1, profile: str = "position") -> Floats:
    """Logarithmic chirp of constant amplitude in position, velocity or acceleration."""
    k = np.log(high_hz / low_hz) / TIME[-1]
    frequency = low_hz * np.exp(k * TIME)
    power = {"position": 0, "velocity": 1, "acceleration": 2}[profile]
    return amplitude * (low_hz / frequency) ** power * np.sin(2 * np.pi * (frequency - low_hz) / k)


def link_of(motor: Floats, mode_hz: float, damping: float = 0.05) -> Floats:
    """The link behind a spring: its motion as the spring's mode answers."""
    ratio = np.fft.rfftfreq(2 * motor.size, 1.0 / RATE) / mode_hz
    response = (1 + 2j * damping * ratio) / (1 - ratio**2 + 2j * damping * ratio)
    return np.fft.irfft(response * np.fft.rfft(motor, 2 * motor.size))[: motor.size]


def torque_of(motor: Floats, inertia: float, friction: float = 0.0) -> Floats:
    velocity = np.gradient(motor, 1.0 / RATE)
    return inertia * np.gradient(velocity, 1.0 / RATE) + friction * np.tanh(velocity / 0.01)


def codes(motor: Floats, torque: Floats, link: Floats | None = None) -> list[str]:
    noise = np.random.default_rng(0).standard_normal((3, motor.size))
    recording = Recording(
        joint="j",
        sample_rate_hz=RATE,
        motor_position=motor + 1e-5 * noise[0],
        motor_torque=torque,
        link_position=None if link is None else link + 2e-5 * noise[1],
    )
    return [notice.code for notice in magnitude_notices(recording)]


JOINTS = {
    "paper": (0.05, 30.0, 0.2, 3.3, 100.0),
    "cobot": (0.1, 30.0, 0.3, 15.0, 1.0),
    "series elastic": (0.1, 20.0, 0.5, 8.0, 0.1),
    "small servo": (0.2, 10.0, 1.0, 40.0, 2e-4),
    "excavator": (0.02, 2.0, 1.0, 0.8, 3e5),
    "above its mode": (10.0, 30.0, 0.05, 3.3, 100.0),
    "turns on and on": (0.1, 0.5, 12.0, 20.0, 1.0),
}


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("profile", ["position", "velocity", "acceleration"])
def test_joints_in_si_units_are_left_in_peace(joint: str, profile: str) -> None:
    low, high, amplitude, mode, inertia = JOINTS[joint]
    if profile == "position":
        amplitude *= 0.2  # at constant amplitude the link would break off at its mode
    motor = chirp(low, high, amplitude=amplitude, profile=profile)
    torque = torque_of(motor, inertia, 0.1 * inertia)
    assert codes(motor, torque) == []
    assert codes(motor, torque, link_of(motor, mode)) == []


@pytest.mark.parametrize("factor", [180.0 / np.pi, 100.0])
@pytest.mark.parametrize("profile", ["position", "velocity"])
def test_degrees_and_motor_shaft_are_named(factor: float, profile: str) -> None:
    motor = chirp(0.2, 20.0, amplitude=0.3, profile=profile)
    assert codes(factor * motor, torque_of(motor, 10.0)) == ["position_not_si"]


@pytest.mark.parametrize("factor", [180.0 / np.pi, np.pi / 180.0, 100.0])
def test_motor_and_link_in_different_units_are_named_however_small_they_are(factor: float) -> None:
    motor = chirp(0.1, 20.0, amplitude=0.002)
    assert codes(factor * motor, torque_of(motor, 10.0), link_of(motor, 5.0)) == ["position_not_si"]


def test_encoder_counts_are_named() -> None:
    motor = chirp(0.1, 5.0)
    recording = Recording(
        joint="j", sample_rate_hz=RATE, motor_position=np.round(2000 * motor), motor_torque=torque_of(motor, 10.0)
    )
    assert [n.code for n in magnitude_notices(recording)] == ["position_not_si"]


def test_raw_units_of_the_drive_are_named() -> None:
    """Thousandths of the rated torque, or milliamperes, as a drive's object dictionary holds them."""
    motor = chirp(0.1, 10.0)
    assert codes(motor, np.round(50.0 * torque_of(motor, 1.0))) == ["effort_not_si"]


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_efforts_that_no_inertia_explains_are_named(factor: float) -> None:
    motor = chirp(0.1, 10.0)
    assert codes(motor, factor * torque_of(motor, 1.0)) == ["effort_not_si"]


def test_coarse_torque_sensor_is_no_counter() -> None:
    motor = chirp(0.1, 10.0)
    assert codes(motor, np.round(torque_of(motor, 0.05, 1.0))) == []
