"""Why more is left than noise, or may be."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flex_ident.errors import UsageError
from flex_ident.gap import GapOptions
from flex_ident.gap.left import Leftover, reasons_left
from flex_ident.likelihood.remainder import Remainder
from flex_ident.notices import Code, Notice, Why
from flex_ident.report.reasons import reason_text

NOISE = Remainder(np.zeros(1), 0.2, 0.2, 0.1, None, "quiet")


def leftover() -> Leftover:
    """Nothing but noise, with nothing named."""
    estimate: Any = SimpleNamespace(left=NOISE, coupling=None, strained=())
    return Leftover(estimate, NOISE, 0.2, named=False)


def suspected(effect: str) -> Notice:
    return Notice(Code.CAUSE_SUSPECTED, effect, {"moved_stds": 6.1, "gain": 300.0})


def test_noise_alone_is_no_reason() -> None:
    assert list(reasons_left(leftover(), GapOptions(), (), ())) == []


@pytest.mark.parametrize(
    ("effect", "why"), [("stribeck_friction", Why.CAUSE_SUSPECTED), ("gain_drift", Why.SCALE_SUSPECTED)]
)
def test_nothing_is_complete_while_an_effect_is_suspected(effect: str, why: Why) -> None:
    """A Stribeck peak of 80 % of the friction was `complete` in three of three of an adversary's legs, and suspected
    in the same output."""
    (reason,) = reasons_left(leftover(), GapOptions(), (), (suspected(effect),))
    assert (reason.why, reason.subject) == (why, effect)
    assert f"{effect} is suspected: it would move the parameters by 6 standard deviations" in reason_text(reason)


def test_an_effect_is_added_by_hand_once() -> None:
    with pytest.raises(UsageError, match="--add names backlash twice"):
        GapOptions(add=("backlash", "backlash"))
