"""Every reason has one sentence, made in `report/`, whatever it is about."""

import math
from string import Formatter

import pytest

from flex_ident.gap.explanation import Region
from flex_ident.gap.objections import within_own_error
from flex_ident.notices import Reason, Why
from flex_ident.report.gap_words import region_text
from flex_ident.report.reasons import SENTENCES, reason_text

INNER = Reason(Why.WITHIN_NOISE)


def fields(template: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(template) if name}


@pytest.mark.parametrize("why", list(Why), ids=str)
def test_every_reason_has_a_sentence(why: Why) -> None:
    template = SENTENCES[why]
    if callable(template):
        return
    cases = {"": template} if isinstance(template, str) else dict(template)
    for case, text in cases.items():
        numbers = dict.fromkeys(fields(text) - {"subject", "because"}, 1.5)
        said = reason_text(Reason(why, "backlash", numbers, case, INNER))
        assert "{" not in said
        assert said[0].islower() or said.startswith(("1.5", "backlash", "BIC"))
        assert not said.endswith(".")


def test_a_reason_of_another_reasons_own_is_told_with_it() -> None:
    said = reason_text(Reason(Why.BESIDE_ANOTHER, "gravity", because=INNER))
    assert said == "with gravity in the model, what was left without it is no more than the noise"


def test_what_changes_little_is_told_of_both_signals() -> None:
    reason = within_own_error({"torque": 1e-4, "deflection": 2e-4}, 2e-3)
    assert reason is not None
    assert reason_text(reason).count("may be wrong by") == 2


def test_a_gap_that_does_not_fall_is_told_with_its_sizes() -> None:
    numbers = {"before": 1.0, "after": 1.1, "before_link_mrad": 0.2, "after_link_mrad": 0.1}
    assert "(1 N m, 0.2 mrad to 1.1 N m, 0.1 mrad)" in reason_text(Reason(Why.GAP_DOES_NOT_FALL, numbers=numbers))
    torque = Reason(Why.GAP_DOES_NOT_FALL, numbers={"before": 1.0, "after": 1.1})
    assert "(1 N m to 1.1 N m)" in reason_text(torque)


def test_a_region_of_the_spectrum_is_no_time() -> None:
    assert region_text(Region("frequency", 0.0, 2.1, 0.98, 0.1, "Hz")).endswith("10 % of the spectrum")
    assert region_text(Region("motor_position", -math.pi, 0.0, 0.5, 0.25, "rad")) == (
        "50 % of the gap above the noise lies where the motor angle is -3.14 to 0 rad, 25 % of the time"
    )
