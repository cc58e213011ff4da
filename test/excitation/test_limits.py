"""Limits from parameters and URDF, and eq. 17."""

import math

import pytest

from flex_ident.errors import ConfigurationError, UsageError
from flex_ident.excitation import Limits
from flex_ident.excitation.limits import gravity_rest, is_continuous, urdf_limits

URDF = """<robot name="r">
<joint name="elbow" type="revolute"><limit lower="-1" upper="2" velocity="3" effort="4"/></joint>
<joint name="wheel" type="continuous"><limit velocity="5" effort="0"/></joint>
<joint name="free" type="floating"/><joint name="base" type="fixed"/>
<joint name="soft" type="revolute"><limit lower="-1" upper="2" velocity="3" effort="4"/>
<safety_controller soft_lower_limit="-0.5" soft_upper_limit="9" k_velocity="1"/></joint>
<joint name="odd" type="revolute"><limit lower="nan" upper="x" velocity="-1"/></joint>
<ros2_control><joint name="soft"><param name="min">-9</param></joint></ros2_control></robot>"""


def test_the_tighter_bound_wins() -> None:
    limits = Limits(-2.0, 1.0, 9.0, 1.0, 0.1).tightened(urdf_limits(URDF, "elbow"))
    assert limits == Limits(-1.0, 1.0, 3.0, 1.0, 0.1)


def test_what_a_urdf_leaves_open_is_open() -> None:
    wheel = urdf_limits(URDF, "wheel")
    assert wheel.position_max == math.inf
    assert wheel.velocity == 5.0
    assert wheel.effort == math.inf
    assert urdf_limits(URDF, "free") == Limits()
    assert urdf_limits(URDF, "odd") == Limits()


def test_soft_limits_of_a_urdf_count() -> None:
    assert urdf_limits(URDF, "soft") == Limits(-0.5, 2.0, 3.0, 4.0)


@pytest.mark.parametrize(("joint", "text"), [("follower", "mimics 'elbow'"), ("passive", "no command interface")])
def test_a_joint_without_a_drive_is_refused_by_name(joint: str, text: str) -> None:
    limit = '<limit lower="-1" upper="2" velocity="3" effort="4"/>'
    urdf = (
        f'<robot name="r"><joint name="follower" type="revolute">{limit}<mimic joint="elbow"/></joint>'
        f'<joint name="passive" type="revolute">{limit}</joint><joint name="driven" type="revolute">{limit}</joint>'
        '<ros2_control><joint name="passive"><state_interface name="position"/></joint>'
        '<joint name="driven"><command_interface name="effort"/><state_interface name="position"/></joint>'
        "</ros2_control></robot>"
    )
    with pytest.raises(UsageError, match=f"'{joint}' .*{text}"):
        urdf_limits(urdf, joint)
    assert urdf_limits(urdf, "driven").position_max == 2.0


def test_a_fixed_joint_is_refused() -> None:
    with pytest.raises(UsageError, match="fixed"):
        urdf_limits(URDF, "base")


@pytest.mark.parametrize(("text", "why"), [("<robot", "not XML"), (URDF, "no joint 'wrist'")])
def test_unusable_descriptions_are_refused(text: str, why: str) -> None:
    with pytest.raises(UsageError, match=why):
        urdf_limits(text, "wrist")


def test_limits_that_leave_nothing_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="position_min"):
        Limits(0.0, 1.0).tightened(Limits(2.0, 3.0))


def test_gravity_rest_is_where_gravity_pulls_nothing() -> None:
    for mx, my, near in ((-0.7, -53.4, 0.0), (3.0, 0.2, 2.0), (1.0, 1.0, -5.0)):
        q = gravity_rest(mx, my, near)
        assert mx * math.cos(q) + my * math.sin(q) == pytest.approx(0.0, abs=1e-9)
        assert abs(q - near) <= math.pi / 2 + 1e-9


@pytest.mark.parametrize(
    ("description", "text"),
    [
        ("<a>\ud800</a>", "is not XML"), ("\0", "is not XML"), ("<a>" * 100_000, "is not XML"),
        ("<!DOCTYPE a [<!ENTITY b '" + "c" * 100_000 + "'>]><a>" + "&b;" * 10_000 + "</a>", "amplification"),
        ("<a/>" + " " * (5 << 20), "are read at most"),
        ("<a><joint name='j' type='revolute'><mimic joint='&#10;&#127;'/></joint></a>", "mimics"),
    ],
)  # fmt: skip
def test_a_description_made_to_hurt_is_refused_in_one_line(description: str, text: str) -> None:
    for read in (urdf_limits, is_continuous):
        if read is is_continuous and text == "mimics":
            continue
        with pytest.raises(UsageError, match=text) as caught:
            read(description, "j")
        assert str(caught.value).isprintable()
