"""No fit knows a measurement chain better than the chain is: what follows it stays open by as much."""

import numpy as np
import pytest

from flex_ident.estimation.chain_known import BEST_KNOWN, with_chain_open
from flex_ident.likelihood.covariance import Uncertainty


def _known(key: str, std: float, *, undetermined: tuple[tuple[str, ...], ...] = ()) -> Uncertainty:
    """MY follows the nuisance by 400 N m a unit, K by nothing; MY alone is known to 0.001, K to 2."""
    follows = np.array([0.0, 400.0, 1.0])
    covariance = np.diag([4.0, 1e-6, 0.0]) + std**2 * np.outer(follows, follows)
    return Uncertainty(("K", "MY", key), covariance, 1.0, 3, undetermined)


@pytest.mark.parametrize("key", BEST_KNOWN)
def test_what_follows_a_nuisance_is_open_by_the_best_that_can_be_known_of_it(key: str) -> None:
    known = _known(key, 1e-3 * BEST_KNOWN[key])
    wider = with_chain_open(known, known)
    assert wider.std("MY") == pytest.approx(400.0 * BEST_KNOWN[key], rel=0.05)
    assert wider.std(key) == pytest.approx(BEST_KNOWN[key], rel=0.01)
    assert wider.std("K") == known.std("K")


@pytest.mark.parametrize("key", BEST_KNOWN)
def test_nothing_changes_where_it_is_open_anyway(key: str) -> None:
    known = _known(key, 100.0 * BEST_KNOWN[key])
    assert with_chain_open(known, known).std("MY") < 1.001 * known.std("MY")


def test_nothing_changes_without_it_or_where_it_is_undetermined_or_at_its_bound() -> None:
    for known in (
        Uncertainty(("K",), np.eye(1), 1.0, 1, ()),
        _known("link_scale", 1e-6, undetermined=(("MY", "link_scale"),)),
        Uncertainty(("K", "MY", "link_scale"), np.zeros((3, 3)), 1.0, 3, ()),
    ):
        np.testing.assert_array_equal(with_chain_open(known, known).covariance, known.covariance)
