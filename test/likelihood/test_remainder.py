"""More than noise, or not: the rule on made-up residuals, and what the noise is known from."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up import RATE, TIME, problem, reduced, white

from flex_ident.likelihood.remainder import Remainder, _rounding, remainder
from flex_ident.likelihood.thresholds import OWN_ERROR, OWN_ERROR_AT_REVERSALS, STRUCTURE
from flex_ident.parameters.values import Values

MOTION = 50.0 * white(7)
"""A torque in which every cell of time and frequency holds motion, above the band too where it is not filtered."""


def left(
    made: Any,
    values: Values | None = None,
    standstill: float = 0.0,
    rounding: float = 0.0,
    most: float = math.inf,
) -> Remainder:
    """The remainder of a fit of a made-up problem, with `standstill`, N m, of friction in every sample, which may be as
    large as `most`, and as much as `rounding`, N m, of what the motor's encoder does."""
    solver: Any = SimpleNamespace(
        problem=made, whitenings=lambda _values: (None,),
        standstill_friction=lambda residual, _whitening: np.full_like(residual, standstill),
        standstill_size=lambda _values: np.full_like(made.torque, most),
        encoder_noise=lambda _values: (np.full_like(made.torque, rounding),),
    )  # fmt: skip
    fit: Any = SimpleNamespace(values=values or Values())
    return remainder(solver, fit)


@pytest.mark.parametrize(
    ("gap", "floor", "own_error", "structured"),
    [
        (1.00, 1.0, 0.0, False),
        (0.99 * STRUCTURE, 1.0, 0.0, False),
        (1.01 * STRUCTURE, 1.0, 0.0, True),
        (2.00, 1.0, 1.8, False),  # sqrt(2^2 - 1) = 1.73
        (2.00, 1.0, 1.7, True),
        (0.40, 1.0, 0.0, False),
        (0.30, 0.0, 0.2, True),
        (0.10, 0.0, 0.2, False),
    ],
)
def test_more_than_noise_and_more_than_the_methods_own_error(
    gap: float, floor: float, own_error: float, structured: bool
) -> None:
    assert Remainder(np.zeros(1), gap, floor, own_error, None, "quiet").structured(gap) is structured


def test_noise_alone_is_not_structure_and_a_steady_tone_is() -> None:
    """A tone that never stops is in the steady part of what is left: only the noise above the band tells."""
    noise = white()
    tone = np.sin(2.0 * np.pi * 7.0 * TIME)
    for added, structured in ((0.0, False), (0.5, True)):
        found = left(problem(noise, residual=reduced(noise + added * tone)))
        assert found.evidence == "above_band"
        assert found.floor == pytest.approx(float(np.std(reduced(noise))), rel=0.1)
        assert found.gap == pytest.approx(float(np.std(reduced(noise + added * tone))), rel=1e-3)
        assert found.structured(found.gap) is structured


def test_what_the_encoder_does_is_noise() -> None:
    made = problem(MOTION + white(), residual=reduced(white()) + 0.5)
    plain, rounded = left(made), left(made, rounding=0.5)
    assert plain.structured(plain.gap)
    assert not rounded.structured(rounded.gap)
    assert rounded.floor == pytest.approx(np.hypot(plain.floor, 0.5))


def test_what_does_not_repeat_is_the_noise() -> None:
    period = TIME.size // 2
    position = np.tile(np.cumsum(white(3, period)), 2)
    position -= position[0]
    noise, error = 0.3 * white(), np.tile(np.sin(2.0 * np.pi * 5.0 * TIME[:period]), 2)
    found = left(problem(MOTION, position, residual=reduced(noise + error)))
    assert found.evidence == "repeats"
    assert found.repeats is not None
    assert found.repeats.period_s == pytest.approx(period / RATE)
    assert found.floor == pytest.approx(float(np.std(reduced(noise))), rel=0.1)
    assert found.repeats.repeatable == pytest.approx(0.5**0.5, rel=0.05)
    assert found.structured(found.gap)


@pytest.mark.parametrize(("moving", "evidence"), [(0.4, "quiet"), (1.0, "none")])
def test_without_repeats_and_without_room_above_only_quiet_cells_tell(moving: float, evidence: str) -> None:
    size = 4000
    noise = white(size=size)
    torque = noise + 300.0 * white(5, size) * (np.arange(size) < moving * size)
    assert left(problem(torque, rate_hz=70.0, decimation=1, residual=noise)).evidence == evidence


@pytest.mark.parametrize(("standstill", "most", "hidden"), [(5.0, math.inf, 5.0), (5.0, 2.0, 2.0), (-5.0, 2.0, 0.0)])
def test_standstill_hides_what_it_explains_and_no_more_than_friction_can_do(
    standstill: float, most: float, hidden: float
) -> None:
    """Friction at standstill that makes what is left larger explains nothing."""
    floor = left(problem(white(), residual=reduced(white()))).floor
    shown = problem(white(), residual=reduced(white()) + 5.0)
    assert left(shown, standstill=standstill, most=most).floor == pytest.approx(np.hypot(floor, hidden), rel=0.02)


def test_own_error_is_a_share_of_torque_and_of_dry_friction() -> None:
    made = problem(MOTION, residual=reduced(white()))
    torque = float(np.sqrt(np.mean(made.torque**2)))
    assert left(made).own_error == pytest.approx(OWN_ERROR * torque)
    dry = left(made, Values({"FSm": 6.0, "FS": 1.0})).own_error
    assert dry == pytest.approx(np.hypot(OWN_ERROR * torque, OWN_ERROR_AT_REVERSALS * 7.0))


def test_rounding_leaves_no_more_in_any_stretch_than_is_there() -> None:
    """Play that strikes another time moves the prediction by far more than was left, and by nothing elsewhere."""
    rate, shown = 100.0, np.ones(4000, bool)
    residual = np.where(np.arange(4000) < 1000, 0.1, 1.0) * white(4, 4000)
    moved = np.where(np.arange(4000) < 1000, 50.0, 0.0) * white(5, 4000)
    assert 0.05 < _rounding(moved, residual, rate, shown) < 0.12  # a stretch reaches across; of all it would be 25
    some = np.where(np.arange(4000) < 1000, 0.5, 0.0) * white(6, 4000)
    assert _rounding(some, residual, rate, shown) == pytest.approx(0.25, rel=0.05)
