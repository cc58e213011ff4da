"""A joint that is taken as rigid has a spring all the same: what it does to the inertia is in the interval."""

import math

import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

LINK, MOTOR = 2.0, 1.0


def slowly_moved(locked_hz: float, seed: int) -> dict[str, float]:
    """Error of J over its standard deviation, and that over J, of a joint with that locked-motor mode, up to 1 Hz."""
    stiffness = LINK * (2.0 * math.pi * locked_hz) ** 2
    truth = {"Jm": MOTOR, "K": stiffness, "JL": LINK, "FVm": 3.0, "FSm": 2.0, "FV": 1.0, "FS": 0.5}
    experiment = Experiment(duration_s=30.0, start_frequency_hz=0.1, end_frequency_hz=1.0, amplitude=0.8)
    recording = virtual_recording(
        JointModel(truth, {}, "slow"), experiment, MeasurementChain(torque_noise=0.002), seed=seed
    )
    result = identify(recording, IdentifyOptions(sensors="motor", rigid=True))
    inertia = result.parameter("J")
    assert inertia.identifiable
    return {"pull": (inertia.value - MOTOR - LINK) / inertia.std, "relative": inertia.std / inertia.value}


@pytest.mark.slow
@pytest.mark.parametrize(("locked_hz", "seed"), [(6.0, 1), (9.0, 2)])
def test_the_inertia_of_a_joint_with_a_spring_is_no_surer_than_the_spring_allows(locked_hz: float, seed: int) -> None:
    found = slowly_moved(locked_hz, seed)
    assert abs(found["pull"]) < 3.0
    assert found["relative"] < 0.05


@pytest.mark.slow
def test_a_stiff_joint_is_known_well() -> None:
    found = slowly_moved(100.0, 3)
    assert abs(found["pull"]) < 3.0
    assert found["relative"] < 0.01
