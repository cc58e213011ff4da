"""A motor's side that rubs less than the link's: a direct drive, or a controller that adds what its friction takes."""

from __future__ import annotations

import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

SMOOTH = JointModel({**COBOT_JOINT.parameters, "FVm": 0.5, "FSm": 0.3}, joint="smooth")


@pytest.mark.slow
@pytest.mark.parametrize("told", ["auto", pytest.param("motor", marks=pytest.mark.campaign)])
def test_it_is_asked_for_and_its_friction_left_open_until_it_is_told(told: str) -> None:
    chain = MeasurementChain.with_bits(18, 18, torque_noise=0.01, jitter=0.0, lost=0.0)
    recording = virtual_recording(SMOOTH, Experiment(duration_s=15.0, sample_rate_hz=250.0), chain, seed=4, link=False)
    result = identify(recording, IdentifyOptions(effort_kind=told))
    asked = [n for n in result.notices if n.code == "effort_kind_open" and n.case == "friction"]
    assert bool(asked) == (told == "auto")
    for key in ("FVm", "FSm"):
        assert not (asked and result.parameter(key).identifiable)
        assert key in result.model.parameters  # what the effort shows is part of the model
    for key in ("Jm", "K", "JL"):
        p = result.parameter(key)
        assert abs(p.value - SMOOTH.value(key)) < 3.0 * p.std
