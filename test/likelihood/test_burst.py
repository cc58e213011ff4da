"""When in a recording the gap lies, where it lies in one short stretch."""

import numpy as np
import pytest

from flex_ident.likelihood.remainder import Remainder
from flex_ident.recording import Floats

TIME = np.arange(0.0, 28.0, 0.01)
NOISE = 0.5


def left(disturbance: Floats) -> Remainder:
    residual = NOISE * np.random.default_rng(3).standard_normal(TIME.size) + disturbance
    return Remainder(residual, float(np.sqrt(np.mean(residual**2))), NOISE, 0.1, None, "quiet")


@pytest.mark.parametrize("seconds", [0.4, 1.5, 2.8])
def test_a_touch_is_found(seconds: float) -> None:
    touched = np.abs(TIME - 6.2 - 0.5 * seconds) < 0.5 * seconds
    found = left(15.0 * touched).burst(TIME)
    assert found is not None
    start, stop = found
    assert start <= 6.4
    assert stop >= 6.0 + 0.6 * seconds
    assert stop - start <= max(1.0, 2.0 * seconds)


def test_a_gap_all_along_is_no_burst() -> None:
    assert left(np.zeros(TIME.size)).burst(TIME) is None
    assert left(2.0 * np.sin(20.0 * TIME)).burst(TIME) is None
    assert left(15.0 * (TIME > 20.0)).burst(TIME) is None
