"""A rigid joint goes through the same likelihood as a flexible one: its nuisances, verdict and intervals."""

import numpy as np
import pytest
from named_cases import rigid_gravity

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import Identification

pytestmark = pytest.mark.slow
RIGID = IdentifyOptions(rigid=True)
SEEDS = range(6)


@pytest.fixture(scope="module")
def results() -> list[Identification]:
    return [identify(rigid_gravity(seed)[0], RIGID) for seed in SEEDS]


def test_it_is_trusted_and_says_what_was_estimated_beside_the_joint(results: list[Identification]) -> None:
    for result in results:
        assert result.verdict == "trusted", [(n.code, n.subject) for n in result.notices]
        assert result.method == "auto"
        assert {p.key for p in result.parameters} == {"J", "FV", "FS", "offset", "MX", "MY"}
        beside = {p.key for p in result.measurement}
        assert {"torque_delay", "effort_lag", "reversal_speed", "presliding", "reversal_lead"} <= beside
        assert not beside & {"link_skew", "link_zero"}


def test_errors_are_what_the_intervals_say(results: list[Identification]) -> None:
    """Pulls over seeds: as large as they should be on the whole, none far off."""
    truth = {**rigid_gravity(0)[1], "offset": 0.0}
    pulls = np.array([[(r.parameter(k).value - v) / r.parameter(k).std for k, v in truth.items()] for r in results])
    assert float(np.max(np.abs(pulls))) < 4.0
    assert 0.4 < float(np.sqrt(np.mean(pulls**2))) < 1.6


def test_no_interval_has_a_floor_that_the_data_do_not_give(results: list[Identification]) -> None:
    """A longer or cleaner recording must be able to say more: the moments are known to less than was once added.

    But for what a gear that yields a little would do to them."""
    for result in results:
        assert result.parameter("MX").relative_std_percent < 0.2
