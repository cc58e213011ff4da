"""No fit knows a link encoder's scale better than the encoder is: what follows it stays open by as much."""

import numpy as np

from flex_ident.estimation.link_calibration import calibration_shift
from flex_ident.estimation.thresholds import LINK_CALIBRATION
from flex_ident.likelihood.covariance import Uncertainty

FREE = ("K", "MY", "link_scale")


def _known(scale_std: float, *, undetermined: tuple[tuple[str, ...], ...] = ()) -> Uncertainty:
    """MY follows the scale by 400 N m a unit, K by nothing; MY alone is known to 0.001, K to 2."""
    follows = np.array([0.0, 400.0, 1.0])
    covariance = np.diag([4.0, 1e-6, 0.0]) + scale_std**2 * np.outer(follows, follows)
    return Uncertainty(FREE, covariance, 1.0, 3, undetermined)


def test_what_follows_the_scale_is_open_by_the_encoders_own_error() -> None:
    known = _known(1e-6)
    shift = calibration_shift(known)
    np.testing.assert_allclose(shift, LINK_CALIBRATION * np.array([0.0, 400.0, 1.0]))
    wider = known.beside(shift)
    assert wider.std("MY") > 0.99 * 400.0 * LINK_CALIBRATION
    assert wider.std("K") == known.std("K")


def test_nothing_changes_where_the_scale_is_open_anyway() -> None:
    known = _known(1e-3)
    assert known.beside(calibration_shift(known)).std("MY") < 1.001 * known.std("MY")


def test_no_shift_without_a_scale_or_where_it_is_undetermined_or_at_its_bound() -> None:
    rest = Uncertainty(("K",), np.eye(1), 1.0, 1, ())
    assert calibration_shift(rest) is None
    assert calibration_shift(_known(1e-6, undetermined=(("MY", "link_scale"),))) is None
    assert calibration_shift(Uncertainty(FREE, np.zeros((3, 3)), 1.0, 3, ())) is None
