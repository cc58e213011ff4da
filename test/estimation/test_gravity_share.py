"""Whether the effort holds the weight of the robot's description: the truth is the virtual joint's own."""

from dataclasses import replace

import numpy as np
import pytest

from flex_ident.estimation.gravity_share import gravity_share, with_gravity_told
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.notices import Code, Notice
from flex_ident.recording import Recording, Weight
from flex_ident.report.sentences import sentence
from flex_ident.simulation.terms import GRAVITY
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

MX, MY = COBOT_JOINT.value("MX"), COBOT_JOINT.value("MY")
CHAIN = MeasurementChain.with_bits(17, 20)
ROUGHLY = Weight(0.8 * MX, 0.8 * MY, 1.0)
"""A description's masses are a fifth off."""


def recorded(*, compensated: bool, weight: Weight | None = ROUGHLY) -> Recording:
    experiment = Experiment(duration_s=15.0, sample_rate_hz=250.0)
    found = virtual_recording(COBOT_JOINT, experiment, CHAIN, seed=3, link=False)
    q = found.motor_position
    load = GRAVITY * (MX * np.cos(q) + MY * np.sin(q)) if compensated else 0.0
    return replace(found, motor_torque=found.motor_torque - load, weight=weight)


def _told(monkeypatch: pytest.MonkeyPatch, share: tuple[float, float] | None, kind: str) -> tuple[str, str, str]:
    monkeypatch.setattr("flex_ident.estimation.gravity_share.gravity_share", lambda *_args, **_more: share)
    recording, found = with_gravity_told(recorded(compensated=False), kind, "motor")
    (notice,) = (n for n in recording.notices if n.code is Code.URDF_GRAVITY)
    assert sentence(notice)
    return notice.case, notice.severity, found


@pytest.mark.parametrize(
    ("share", "kind", "case", "severity", "found"),
    [
        ((1.2, 0.02), "auto", "held", "info", "auto"),
        ((0.1, 0.02), "auto", "absent", "info", "gravity_compensated"),
        ((0.1, 0.02), "gravity_compensated", "absent", "info", "gravity_compensated"),
        ((0.1, 0.02), "motor", "against", "doubt", "motor"),
        ((1.0, 0.02), "gravity_compensated", "against", "doubt", "gravity_compensated"),
        ((0.5, 0.02), "auto", "other", "info", "auto"),
        ((0.1, 0.4), "auto", "open", "info", "auto"),
        (None, "auto", "open", "info", "auto"),
    ],
)
def test_what_follows_from_a_share(
    monkeypatch: pytest.MonkeyPatch, share: tuple[float, float] | None, kind: str, case: str, severity: str, found: str
) -> None:
    assert _told(monkeypatch, share, kind) == (case, severity, found)


def test_without_a_description_nothing_is_told() -> None:
    plain = recorded(compensated=False, weight=None)
    assert with_gravity_told(plain, "auto", "motor") == (plain, "auto")


def test_a_weight_that_moved_or_is_none_tells_nothing() -> None:
    for weight in (replace(ROUGHLY, moving=("waist",)), Weight(0.0, 0.0, 1.0)):
        assert gravity_share(recorded(compensated=False, weight=weight), "motor") is None


def test_what_was_taken_for_granted_is_said() -> None:
    moved, _ = with_gravity_told(
        recorded(compensated=False, weight=replace(ROUGHLY, moving=("waist",))), "auto", "motor"
    )
    assert "waist moved" in sentence(moved.notices[-1])


@pytest.mark.campaign
def test_an_effort_less_gravity_is_told_from_the_motors_torque_by_the_motor_alone() -> None:
    """Without the description the motor alone leaves the kind of effort open."""
    whole, less = (identify(recorded(compensated=c)) for c in (False, True))
    for result, case in ((whole, "held"), (less, "absent")):
        (notice,) = (n for n in result.notices if n.code is Code.URDF_GRAVITY)
        assert notice.case == case
        assert Code.EFFORT_KIND_UNCLEAR not in {n.code for n in result.notices}
    assert Code.EFFORT_GRAVITY_COMPENSATED in {n.code for n in less.notices}
    for key in ("K", "JL"):
        p = less.parameter(key)
        assert abs(p.value - COBOT_JOINT.value(key)) < 3.0 * p.std, key


def test_of_a_current_and_for_the_papers_equations_nothing_is_told() -> None:
    """A current of unknown scale has no share, and the paper's equations are of the motor's torque."""
    for recording, kind in (
        (recorded(compensated=True), "current"),
        (replace(recorded(compensated=True), notices=(Notice(Code.EFFORT_CURRENT, "motor_torque"),)), "auto"),
    ):
        assert with_gravity_told(recording, kind, "motor") == (recording, kind)
    result = identify(recorded(compensated=True), IdentifyOptions(method="weighted", rigid=True))
    assert Code.URDF_GRAVITY not in {n.code for n in result.notices}
