"""Other joints that move: counted, named, and tested against what the model leaves; a rigid joint of closed form."""

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap.explain import explain
from flex_ident.gap.options import GapOptions
from flex_ident.recording import Recording
from flex_ident.report.gap_words import unexplained_text

RATE_HZ = 500.0
Floats = NDArray[np.float64]


def sines(t: Floats, parts: tuple[tuple[float, float, float], ...], order: int = 0) -> Floats:
    """A sum of sines of amplitude, Hz and phase, or its derivative of that order."""
    total = np.zeros(t.size)
    for amplitude, hz, phase in parts:
        omega = 2.0 * np.pi * hz
        total += amplitude * omega**order * np.sin(omega * t + phase + 0.5 * np.pi * order)
    return total


OWN = ((1.2, 0.2, 0.3), (0.5, 0.6, 1.0), (0.2, 1.4, 2.0), (0.06, 2.8, 0.5))
OTHER = ((0.8, 0.31, 0.1), (0.3, 0.77, 2.0), (0.1, 1.9, 0.7))
UNRELATED = ((0.5, 0.43, 1.0), (0.2, 1.13, 0.2))


def rigid_recording(coupling: float, *, others: tuple[str, ...] = ("other",), seed: int = 1) -> Recording:
    """J 1.1, FV 8.5, FS 5.5; `coupling` kg m^2 and as much gravity of a joint that moves along OTHER."""
    t = np.arange(round(20.0 * RATE_HZ)) / RATE_HZ
    q, v, a = (sines(t, OWN, k) for k in range(3))
    torque = 1.1 * a + 8.5 * v + 5.5 * np.tanh(v / 2e-3)
    where, acceleration = sines(t, OTHER), sines(t, OTHER, 2)
    torque = torque + coupling * (acceleration + 5.0 * np.sin(where))
    noise = 0.01 * np.std(torque) * np.random.default_rng(seed).standard_normal(t.size)
    moved: Mapping[str, Floats] = {"other": where, "third": sines(t, UNRELATED)}
    return Recording(
        joint="joint", sample_rate_hz=RATE_HZ, motor_position=np.round(q / 5e-6) * 5e-6, motor_torque=torque + noise,
        others={name: moved[name] for name in others},
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("coupling", [0.3, 1.0])
def test_torque_of_another_joint_is_seen_and_nothing_is_complete(coupling: float) -> None:
    recording = rigid_recording(coupling)
    result = identify(recording, IdentifyOptions(rigid=True))
    notice = next(n for n in result.notices if n.code == "other_joints_explain")
    assert notice.numbers["share_percent"] > 80.0
    assert notice.texts["joints"] == "other"
    assert result.verdict != "trusted"
    found = explain(recording, GapOptions(rigid=True))
    assert found.verdict != "complete"
    assert "other" in unexplained_text(found)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(s, marks=pytest.mark.campaign) for s in range(2, 6))])
def test_joints_that_move_and_load_nothing_are_no_cause(seed: int) -> None:
    result = identify(rigid_recording(0.0, others=("other", "third"), seed=seed), IdentifyOptions(rigid=True))
    assert "other_joints_explain" not in {n.code for n in result.notices}


def test_torque_of_a_joint_that_is_not_recorded_is_not_another_ones() -> None:
    result = identify(rigid_recording(1.0, others=("third",)), IdentifyOptions(rigid=True))
    notices = [n for n in result.notices if n.code == "other_joints_explain"]
    assert not notices
    assert result.verdict != "trusted"
