"""The gap falls in the torque, or in the link's position where that is what an effect shows in."""

import pytest

from flex_ident.gap.sizes import GapSize


def test_without_a_link_encoder_the_torque_decides() -> None:
    assert GapSize(0.99).falls_from(GapSize(1.0))
    assert not GapSize(1.0).falls_from(GapSize(1.0))
    assert not GapSize(1.01).falls_from(GapSize(1.0))


def test_with_one_both_decide_together() -> None:
    before = GapSize(1.0, 1e-4)
    assert GapSize(1.0, 0.5e-4).falls_from(before)
    assert GapSize(1.05, 0.2e-4).falls_from(before)  # five times less of the link, five per cent more of the torque
    assert GapSize(0.5, 1e-4).falls_from(before)
    assert not GapSize(1.05, 1e-4).falls_from(before)
    assert not GapSize(1.01, 0.995e-4).falls_from(before)
    assert not GapSize(0.99, 1.02e-4).falls_from(before)


def test_it_is_given_to_reasons_with_its_units() -> None:
    assert GapSize(0.21).numbers("after") == {"after": 0.21}
    assert GapSize(0.21, 2e-5).numbers("before") == {"before": 0.21, "before_link_mrad": pytest.approx(0.02)}
