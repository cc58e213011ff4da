"""Recordings of less than a second: refused or rejected, never an exception of numpy's."""

from contextlib import suppress

import numpy as np
import pytest

from flex_ident.errors import FlexIdentError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.recording import Recording


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.08, 0.3, 0.7])
@pytest.mark.parametrize("sensors", ["motor", "motor+link"])
def test_short_recordings_end_in_a_sentence(seconds: float, sensors: str) -> None:
    rate = 1000.0
    time = np.arange(round(seconds * rate)) / rate
    rng = np.random.default_rng(0)
    position = 0.05 * np.sin(2.0 * np.pi * 15.0 * time)
    torque = 1.5 * np.gradient(np.gradient(position, time), time) + 5.0 * np.sign(np.gradient(position, time))
    link = position + 1e-4 * rng.standard_normal(time.size)
    recording = Recording("j", rate, position, torque + 0.1 * rng.standard_normal(time.size), link_position=link)
    with suppress(FlexIdentError):
        assert identify(recording, IdentifyOptions(sensors=sensors)).verdict in ("rejected", "doubtful")
