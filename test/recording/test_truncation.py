"""Efforts cut toward zero are told from those rounded, and put right on average."""

from collections.abc import Callable

import numpy as np
import pytest

from flex_ident.notices import Code
from flex_ident.recording import Floats
from flex_ident.recording.mending import mended_signals
from flex_ident.recording.recording import Signal
from flex_ident.recording.truncation import EffortGrid, effort_grid, grid_step

RATE_HZ, SECONDS, STEP = 500.0, 30.0, 0.25
TIME = np.arange(0.0, SECONDS, 1.0 / RATE_HZ)


def effort(noise: float, seed: int = 1) -> Floats:
    """A weight, a chirp's inertia and dry friction, N m."""
    phase = 2.0 * np.pi * (0.2 * TIME + 0.1 * TIME**2)
    own = 2.0 * np.cos(0.7 * TIME) + 6.0 * np.sin(phase) + 1.5 * np.sign(np.cos(phase))
    return np.asarray(own + noise * np.random.default_rng(seed).standard_normal(TIME.size))


@pytest.mark.parametrize("noise", [0.02, 0.2, 1.0])
@pytest.mark.parametrize("scale", [1.0, 0.0137])
def test_an_effort_that_was_cut_is_found(noise: float, scale: float) -> None:
    cut = scale * STEP * np.trunc(effort(noise) / STEP)
    for recorded in (cut, cut.astype(np.float32).astype(float)):
        found = effort_grid(recorded)
        assert found is not None
        assert found == (pytest.approx(scale * STEP, rel=1e-5), True)


@pytest.mark.parametrize("noise", [0.02, 0.2, 1.0])
@pytest.mark.parametrize("whole", [np.rint, np.floor])
def test_an_effort_that_was_rounded_is_told(noise: float, whole: Callable[[Floats], Floats]) -> None:
    found = effort_grid(STEP * whole(effort(noise) / STEP))
    assert found is not None
    assert found == (pytest.approx(STEP), False)


def test_an_effort_that_hardly_passes_zero_does_not_tell() -> None:
    assert effort_grid(STEP * np.trunc((effort(0.2) + 20.0) / STEP)) == EffortGrid(STEP, None)


def test_an_effort_that_rests_at_zero_is_left() -> None:
    rounded = STEP * np.rint(effort(0.2) / STEP)
    for share in (0.02, 0.1, 0.5):
        resting = rounded.copy()
        resting[: int(share * resting.size)] = 0.0
        assert effort_grid(resting) == (STEP, False)
    dead = effort_grid(np.where(np.abs(rounded) < 4.0 * STEP, 0.0, rounded))
    assert dead is not None
    assert not dead.cut


@pytest.mark.parametrize("values", [np.zeros(50), np.full(50, 2.0), np.array([1.0]), effort(0.1)])
def test_what_lies_on_no_grid_has_no_step(values: Floats) -> None:
    assert effort_grid(values) is None or values[0] == 2.0
    assert grid_step(effort(0.1)) == 0.0


def test_half_a_step_is_put_back_and_said() -> None:
    true = effort(0.2)
    position = Signal("motor_position", "/joint_states:a.position", "header", TIME, 0.3 * np.sin(TIME))
    cut = Signal("motor_torque", "/joint_states:a.effort", "header", TIME, STEP * np.trunc(true / STEP))
    signals, notices = mended_signals([position, cut])
    [notice] = notices
    assert (notice.code, notice.subject) == (Code.EFFORT_TRUNCATED, cut.source)
    assert notice.numbers["step"] == pytest.approx(STEP)
    error = signals[1].values - true
    large = np.abs(true) > 2.0 * STEP
    assert abs(float(np.mean(error[large] * np.sign(true[large])))) < 0.01 * STEP
