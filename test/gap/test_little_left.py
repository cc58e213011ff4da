"""What is no more than noise is not explained; what may be the method's own error must be explained whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from flex_ident.gap.search import _best, _doubted, _is_noise, _is_nothing
from flex_ident.likelihood.remainder import LinkRemainder, Remainder
from flex_ident.notices import Reason, Why
from flex_ident.report.reasons import reason_text


@dataclass(frozen=True)
class Tried:
    """What a trial says of itself."""

    share: float
    objection: Reason | None = None
    effect: str = "cable_torque"


def left(gap: float, *, own_error: float = 0.3, link_gap: float = 0.0) -> Remainder:
    """A remainder over noise of 0.2 N m, of a joint whose spring gives way by 1 mrad."""
    link = LinkRemainder(link_gap, 1e-6, 1e-3) if link_gap else None
    return Remainder(np.zeros(1), gap, 0.2, own_error, None, "quiet", link)


@pytest.mark.parametrize(
    ("remainder", "noise", "nothing"),
    [
        (left(0.21), True, True),
        (left(0.27), False, True),  # more than noise, within the method's own error
        (left(0.40), False, False),
        (left(0.21, link_gap=2e-6), True, True),
        (left(0.21, link_gap=2e-5), False, False),  # a link encoder shows it
    ],
)
def test_noise_and_the_methods_own_error(remainder: Remainder, noise: bool, nothing: bool) -> None:
    assert (_is_noise(remainder), _is_nothing(remainder)) == (noise, nothing)


def test_of_what_may_be_the_methods_own_error_a_part_is_no_evidence() -> None:
    part: Any = Tried(0.77)
    whole: Any = Tried(0.94)
    refused: Any = Tried(0.1, Reason(Why.WITHIN_NOISE))
    assert "77 % only" in reason_text(_doubted(part).objection)
    assert _doubted(whole) is whole
    assert _doubted(refused) is refused


def test_what_identification_fits_itself_comes_before_what_imitates_it() -> None:
    first: Any = Tried(0.96)
    constant: Any = Tried(0.95, effect="torque_offset")
    half: Any = Tried(0.5, effect="torque_offset")
    refused: Any = Tried(0.96, Reason(Why.WITHIN_NOISE), "torque_offset")
    assert _best([first, constant], ["torque_offset"]) is constant
    assert _best([first, constant], []) is first
    assert _best([first, half], ["torque_offset"]) is first
    assert _best([first, refused], ["torque_offset"]) is first
    assert _best([refused], ["torque_offset"]) is None
