"""The published parameters of a real drive (EMPS), which is not part of the project: skipped where it is missing."""

from pathlib import Path

import pytest

from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.regression import identify_linear

EMPS = Path(__file__).resolve().parents[3] / "shared" / "real" / "emps_train"
PUBLISHED = {"J": (95.1089, 0.3), "FV": (203.5034, 2.3), "FS": (20.3935, 0.2), "offset": (-3.1648, 0.1)}


@pytest.mark.skipif(not EMPS.exists(), reason="needs ../shared/real/emps_train")
@pytest.mark.parametrize("key", PUBLISHED)
def test_published_parameter_is_met(key: str) -> None:
    result = identify_linear(
        read_recording(EMPS, SignalSelection(joint="emps_axis")), sensors="motor", method="weighted", rigid=True
    )
    assert [p.key for p in result.parameters] == [*PUBLISHED]  # no gravity on an axis that slides level
    value, allowed = PUBLISHED[key]
    found = result.parameter(key)
    assert found.value == pytest.approx(value, abs=allowed)
    assert abs(found.value - value) <= 2.0 * found.std
