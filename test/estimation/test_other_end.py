"""Two ends of a fit that are as likely: what lies between them is in the intervals, and is said."""

from dataclasses import replace

import numpy as np

from flex_ident.estimation.other_end import other_end
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.likelihood.fit import Fit
from flex_ident.parameters.values import Values

FREE = ("K", "FV")
FIT = Fit(
    FREE, Values({"K": 1e4, "FV": 2.0}), np.eye(2), np.zeros(2), (np.arange(2),), np.zeros((2, 2)), (), (), 0.0
)  # fmt: skip
KNOWN = Uncertainty(FREE, np.diag([100.0, 0.01]), 1.0, 2, ())


def test_ends_that_are_apart_are_told_and_both_are_in_the_interval() -> None:
    found = other_end(replace(FIT, rival=Values({"K": 1.05e4, "FV": 2.3})), KNOWN)
    assert found is not None
    assert (found.key, found.here, found.there) == ("K", 1e4, 1.05e4)
    np.testing.assert_allclose(found.shift, [500.0, 0.3])
    assert KNOWN.beside(found.shift).std("K") > 500.0


def test_ends_in_one_valley_are_one() -> None:
    assert other_end(FIT, KNOWN) is None
    assert other_end(replace(FIT, rival=Values({"K": 1.001e4, "FV": 2.0})), KNOWN) is None  # one standard deviation


def test_friction_alone_makes_no_two_ends() -> None:
    assert other_end(replace(FIT, rival=Values({"K": 1e4, "FV": 5.0})), KNOWN) is None


def test_what_is_not_known_at_all_is_not_compared() -> None:
    nothing = replace(KNOWN, undetermined=(("K",),))
    assert other_end(replace(FIT, rival=Values({"K": 2e4, "FV": 2.0})), nothing) is None
