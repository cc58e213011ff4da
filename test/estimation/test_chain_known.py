"""No fit knows a measurement chain better than the chain is: what follows it stays open by as much."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flex_ident.estimation.chain_known import averaging_shift, scale_shift, with_chain_open
from flex_ident.estimation.identified import cancelled_error
from flex_ident.estimation.thresholds import AVERAGING_KNOWN, LINK_CALIBRATION
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.parameters.values import Values

FREE = ("K", "MY", "link_scale")


def _known(scale_std: float, *, undetermined: tuple[tuple[str, ...], ...] = ()) -> Uncertainty:
    """MY follows the scale by 400 N m a unit, K by nothing; MY alone is known to 0.001, K to 2."""
    follows = np.array([0.0, 400.0, 1.0])
    covariance = np.diag([4.0, 1e-6, 0.0]) + scale_std**2 * np.outer(follows, follows)
    return Uncertainty(FREE, covariance, 1.0, 3, undetermined)


def test_what_follows_the_scale_is_open_by_the_encoders_own_error() -> None:
    known = _known(1e-6)
    shift = scale_shift(known)
    np.testing.assert_allclose(shift, LINK_CALIBRATION * np.array([0.0, 400.0, 1.0]))
    wider = with_chain_open(known, known, Values({}), 1e-3)
    assert wider.std("MY") > 0.99 * 400.0 * LINK_CALIBRATION
    assert wider.std("K") == known.std("K")


def test_nothing_changes_where_the_scale_is_open_anyway() -> None:
    known = _known(1e-3)
    assert with_chain_open(known, known, Values({}), 1e-3).std("MY") < 1.001 * known.std("MY")


def test_no_shift_without_a_scale_or_where_it_is_undetermined_or_at_its_bound() -> None:
    assert scale_shift(Uncertainty(("K",), np.eye(1), 1.0, 1, ())) is None
    assert scale_shift(_known(1e-6, undetermined=(("MY", "link_scale"),))) is None
    assert scale_shift(Uncertainty(FREE, np.zeros((3, 3)), 1.0, 3, ())) is None


def test_averaging_passes_for_inertia_of_the_motor_and_leaves_the_mode_where_it_is() -> None:
    values = Values({"Jm": 0.4, "K": 2e4, "JL": 4.0})
    shift = averaging_shift(("FV", "Jm", "K", "JL"), values, 5e-3)
    assert shift is not None
    friction, motor, stiffness, link = shift
    assert friction == 0.0
    assert motor == pytest.approx(AVERAGING_KNOWN * 0.5)
    assert link == -motor
    assert stiffness / 2e4 == pytest.approx(link / 4.0)
    assert averaging_shift(("K", "JL"), values, 5e-3) is None


@pytest.mark.parametrize(
    ("delay", "lag", "doubled"),
    [(-3.3e-4, 3.4e-4, True), (1.0e-4, 3.4e-4, False), (-3.3e-4, 0.0, False), (0.0, 3.4e-4, False)],
)
def test_a_low_pass_that_a_delay_cancels_is_known_half_as_well(delay: float, lag: float, doubled: bool) -> None:
    values = Values({"torque_delay": delay, "effort_lag": lag, "K": 1.0})
    uncertainty = SimpleNamespace(std=lambda _key: 1.2e-4)
    estimate: Any = SimpleNamespace(fit=SimpleNamespace(values=values), uncertainty=uncertainty)
    for key in ("torque_delay", "effort_lag"):
        whole = np.hypot(1.2e-4, cancelled_error(estimate, key))
        assert whole == pytest.approx(2.4e-4 if doubled else 1.2e-4)
    assert cancelled_error(estimate, "K") == 0.0
