"""Truth from MuJoCo: the virtual joint moves as it does, and identification finds what was put in."""

import numpy as np
import pytest

pytest.importorskip("mujoco")

from mujoco_joint import mujoco_motion, mujoco_recording

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import Identification, JointModel
from flex_ident.virtual_joint import COBOT_JOINT, JOINTS, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_motion


@pytest.mark.parametrize(
    "effects",
    [{}, {"backlash": {"gap": 8e-4}}, {"joint_damping": {"damping": 5.0}}, {"torque_offset": {"offset": 3.0}},
     {"second_mode": {"inertia": 0.2, "stiffness": 3000.0, "damping": 0.5}}, {"saturation": {"limit": 30.0}}],
    ids=lambda effects: next(iter(effects), "none"),
)  # fmt: skip
def test_two_plants_move_alike(effects: dict[str, dict[str, float]]) -> None:
    model = JointModel(COBOT_JOINT.parameters, effects)
    experiment = Experiment(duration_s=15.0)
    ours, theirs = virtual_motion(model, experiment), mujoco_motion(model, experiment)
    skip = slice(200, None)
    for name, tolerance in (("motor_position", 2e-3), ("link_position", 2e-3), ("torque", 3e-2)):
        a, b = getattr(ours, name)[skip], getattr(theirs, name)[skip]
        assert np.std(a - b) < tolerance * np.std(b), name


def checked(result: Identification, model: JointModel, *, keys: tuple[str, ...], percent: float) -> None:
    """Assert that the `keys` lie within `percent` and four reported standard deviations of the model's."""
    found = {parameter.key: parameter for parameter in result.parameters}
    for key in keys:
        parameter, truth = found[key], model.value(key)
        error = parameter.value - truth
        assert abs(error) < 0.01 * percent * abs(truth), f"{key}: {100 * error / truth:.2f} %"
        assert abs(error) < 4.0 * parameter.std, f"{key}: {error / parameter.std:.1f} sigma"


@pytest.mark.parametrize(
    ("name", "sensors", "kind"),
    [
        pytest.param("paper", "motor", "auto", marks=pytest.mark.slow),
        pytest.param("cobot", "motor+link", "auto", marks=pytest.mark.campaign),
        pytest.param("series_elastic", "motor", "motor", marks=pytest.mark.campaign),
    ],
)
def test_identification_recovers_mujocos_joint(name: str, sensors: str, kind: str) -> None:
    """So light a link may as well be one whose controller adds the gravity: what the effort is must be told."""
    chain = MeasurementChain(torque_noise=0.01, jitter=0.05, lost=0.002)
    recording = mujoco_recording(JOINTS[name], Experiment(duration_s=30.0), chain, seed=5)
    result = identify(recording, IdentifyOptions(sensors=sensors, effort_kind=kind))
    assert result.verdict == "trusted"
    checked(result, JOINTS[name], keys=("Jm", "K", "JL"), percent=1.0)
    checked(result, JOINTS[name], keys=("FSm", "FVm", "FV", "FS"), percent=5.0)
