"""The link's dry friction turns over at once in the simulation; where it does not, the intervals say so."""

import sys
from pathlib import Path

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import pytest  # noqa: E402
from plants import Case, case_of, made  # noqa: E402
from recordings import recording_of  # noqa: E402

from flex_ident.estimation.identification import identify  # noqa: E402
from flex_ident.estimation.options import IdentifyOptions  # noqa: E402


def pulls(case: Case) -> dict[str, float]:
    """Errors of the link's frictions over their standard deviations, by the motor alone."""
    joint = made(case)
    result = identify(recording_of(joint.recorded, "motor"), IdentifyOptions(sensors="motor"))
    found = {key: result.parameter(key) for key in ("FV", "FS")}
    return {key: (p.value - joint.truth[key]) / p.std for key, p in found.items()}


@pytest.mark.campaign
@pytest.mark.parametrize("index", [32, 14])
def test_friction_that_turns_over_with_speed_is_within_the_intervals(index: int) -> None:
    """FV was 6 and 3.5 standard deviations off."""
    case = case_of(461, index)
    assert case.friction == "tanh"
    found = pulls(case)
    assert all(abs(pull) < 3.0 for pull in found.values()), found
