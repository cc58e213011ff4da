"""An accepted effect is judged again: where nothing tells the noise, it must close a good part of all that is left."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from flex_ident.gap.final import _fails
from flex_ident.gap.sizes import GapSize

CANDIDATE = SimpleNamespace(effect="torque_offset", scaled=("torque_offset.torque",))


BEFORE = GapSize(1.0)


def _judged(after: GapSize, *, evidence: str, before: GapSize = BEFORE, std: float = 0.01) -> str:
    known = SimpleNamespace(std=lambda _key: std)
    fit = SimpleNamespace(values={"torque_offset.torque": 1.0})
    estimate = SimpleNamespace(left=SimpleNamespace(evidence=evidence), plain=known, uncertainty=known, fit=fit)
    return _fails(cast(Any, CANDIDATE), before, after, cast(Any, estimate))


@pytest.mark.parametrize(("after", "held"), [(0.95, False), (0.85, True)])
def test_where_the_noise_is_unknown_a_small_fall_is_no_cause(after: float, held: bool) -> None:
    """0.221 to 0.206 N m under a PRBS at full torque had been put down to a base that gives way."""
    why = _judged(GapSize(after), evidence="none")
    assert (why == "") == held
    assert held or "nothing tells how much of the gap is noise" in why


def test_where_it_is_known_any_fall_counts_that_is_certain() -> None:
    assert _judged(GapSize(0.95), evidence="quiet") == ""
    assert "does not fall" in _judged(GapSize(1.0), evidence="quiet")
    assert "2.0 standard deviations" in _judged(GapSize(0.95), evidence="quiet", std=0.5)
    assert "1.0 standard deviations" in _judged(GapSize(0.95), evidence="quiet", std=1.0)


def test_a_link_encoder_tells_what_the_torque_does_not() -> None:
    assert _judged(GapSize(0.99, 0.5e-4), evidence="none", before=GapSize(1.0, 1e-4)) == ""
