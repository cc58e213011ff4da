"""The band that a user gives: used as given, or refused with what the recording can hold."""

import numpy as np
import pytest

from flex_ident.errors import UsageError
from flex_ident.estimation.estimate import fit_problem
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap import GapOptions
from flex_ident.recording import Recording

RATE_HZ = 200.0
TIME = np.arange(4000) / RATE_HZ
SWEEP = np.sin(2.0 * np.pi * (0.2 + 0.5 * TIME) * TIME)
RECORDING = Recording("j", RATE_HZ, SWEEP, 0.3 * np.sign(np.gradient(SWEEP)) - SWEEP)


def test_the_band_is_the_one_that_is_given() -> None:
    assert fit_problem(RECORDING, sensors="motor", band_hz=7.5).band_hz == 7.5


@pytest.mark.parametrize("band_hz", [0.1, 81.0, 500.0])
def test_a_band_that_the_recording_cannot_hold_is_refused_with_what_it_can(band_hz: float) -> None:
    with pytest.raises(UsageError, match=r"--band .* between 0.4 and 80 Hz"):
        fit_problem(RECORDING, sensors="motor", band_hz=band_hz)


@pytest.mark.parametrize("band_hz", [-1.0, float("nan"), 1e5])
def test_what_is_no_frequency_is_refused(band_hz: float) -> None:
    with pytest.raises(UsageError, match="--band"):
        IdentifyOptions(band_hz=band_hz)
    with pytest.raises(UsageError, match="--band"):
        GapOptions(band_hz=band_hz)


def test_the_papers_method_has_a_filter_of_its_own() -> None:
    with pytest.raises(UsageError, match="--band goes with --method auto"):
        IdentifyOptions(band_hz=10.0, method="paper")
