"""Kinds of effort that are none, or cannot be used, are refused in one line that says so."""

import pytest

from flex_ident.errors import UsageError
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap.options import GapOptions
from flex_ident.parameters.effort_kinds import USABLE

BOTH = pytest.mark.parametrize("options", [IdentifyOptions, GapOptions])


@BOTH
@pytest.mark.parametrize("kind", USABLE)
def test_kinds_that_can_be_used_are_taken(options: type, kind: str) -> None:
    assert options(effort_kind=kind).effort_kind == kind


@BOTH
def test_unsigned_is_refused_by_name(options: type) -> None:
    with pytest.raises(UsageError, match=r"unsigned: .*with its sign"):
        options(effort_kind="unsigned")


@BOTH
def test_a_kind_that_is_none_is_refused(options: type) -> None:
    with pytest.raises(UsageError, match="expected one of auto, motor"):
        options(effort_kind="torque")


def test_linear_methods_know_the_motors_torque_only() -> None:
    with pytest.raises(UsageError, match="needs --method auto"):
        IdentifyOptions(method="paper", effort_kind="joint_sensor")
    IdentifyOptions(method="paper", effort_kind="motor")
