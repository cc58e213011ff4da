"""Backlash of a MuJoCo tendon is named, sized and added; friction that no effect of the catalogue has is not."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from mujoco_joint import mujoco_recording

from flex_ident.gap import GapExplanation, explain
from flex_ident.gap.units import prismatic_explanation
from flex_ident.recording import Recording
from flex_ident.report.gap_result import gap_content
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

EXPERIMENT = Experiment(duration_s=16.0, sample_rate_hz=250.0)
CHAIN = MeasurementChain(torque_disturbance=0.005)
GAP = 3e-4


def recorded(effect: str = "", *, link: bool = True, seed: int = 0, **parameters: float) -> Recording:
    model = COBOT_JOINT.with_effect(effect, parameters) if effect else COBOT_JOINT
    return virtual_recording(model, EXPERIMENT, CHAIN, seed=seed, link=link)


@pytest.fixture(scope="module")
def backlash() -> GapExplanation:
    return explain(mujoco_recording(COBOT_JOINT.with_effect("backlash", {"gap": GAP}), EXPERIMENT, CHAIN, seed=3))


@pytest.mark.slow
def test_backlash_of_a_mujoco_tendon_is_named_and_measured(backlash: GapExplanation) -> None:
    assert [f.effect for f in backlash.findings] == ["backlash"]
    (finding,) = backlash.findings
    (gap,) = finding.parameters
    assert gap.key == "gap"
    assert abs(gap.value - GAP) < max(4.0 * gap.std, 0.02 * GAP)
    assert backlash.verdict == "explained"
    assert finding.gap_after < 0.3 * finding.gap_before
    assert backlash.final.model.value("backlash.gap") == gap.value


@pytest.mark.slow
def test_all_parameters_are_right_again_once_the_effect_is_in_the_model(backlash: GapExplanation) -> None:
    for key in ("Jm", "K", "JL"):
        found = backlash.final.parameter(key)
        assert abs(found.value / COBOT_JOINT.value(key) - 1.0) < max(4.0 * found.std / found.value, 0.005)


@pytest.mark.slow
def test_gap_json_holds_what_the_interface_promises(backlash: GapExplanation) -> None:
    content = json.loads(json.dumps(gap_content(backlash), allow_nan=False))
    assert content["schema"] == "flex_ident/gap/1"
    promised = {"joint", "sensors", "verdict", "gap", "where", "findings", "unexplained", "parameters"}
    assert promised <= set(content)
    assert {"unit", "measured_on", "before", "after", "noise_floor", "steps"} <= set(content["gap"])
    assert [s["model"] for s in content["gap"]["steps"]] == ["base", "base + backlash"]
    assert content["gap"]["steps"][0]["gap"] == content["gap"]["before"]
    (finding,) = content["findings"]
    assert {"effect", "verdict", "confidence", "gap_before", "gap_after", "parameters", "evidence"} <= set(finding)
    assert {"variable", "range", "share_of_gap", "text"} <= set(content["where"][0])
    assert content["parameters"]["backlash.gap"]["unit"] == "rad"


@pytest.mark.slow
def test_a_joint_that_slides_is_told_in_newtons_and_metres(backlash: GapExplanation) -> None:
    sliding = prismatic_explanation(backlash)
    told = json.dumps(gap_content(sliding)) + "".join(p.unit for pair in sliding.profiles.values() for p in pair)
    assert not re.search(r"\brad\b|\bN m\b|kg m\^2", told)
    assert sliding.findings[0].parameters[0].unit == "m"


@pytest.mark.slow
@pytest.mark.campaign
def test_cubic_stiffness_is_named_from_the_motor_alone() -> None:
    cubic = 0.15 * COBOT_JOINT.value("K") / 2e-3**2
    found = explain(recorded("nonlinear_stiffness", link=False, cubic=cubic))
    assert [f.effect for f in found.findings] == ["nonlinear_stiffness"]
    (parameter,) = found.findings[0].parameters
    assert (
        abs(parameter.value - cubic) < 0.08 * cubic
    )  # the motor alone; the jump of the resonance leaves several minima


@pytest.mark.slow
@pytest.mark.campaign
def test_friction_that_jumps_at_an_angle_is_friction_that_varies_with_it() -> None:
    """Harmonic by harmonic, of 1, 3 and 5 times one spatial frequency, as a step has them."""
    plain = recorded(link=False)
    velocity = np.gradient(plain.motor_position) * plain.sample_rate_hz
    jump = 4.0 * np.sign(velocity) * (plain.motor_position > 0.02)
    found = explain(replace(plain, motor_torque=plain.motor_torque + jump))
    assert {f.effect for f in found.findings} == {"position_dependent_friction"}
    assert found.after < 0.25 * found.before
    assert any(r.variable == "motor_position" for r in found.where)
