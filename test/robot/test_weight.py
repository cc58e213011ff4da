"""What a URDF says of the weight on a joint, against the slope of the potential of its own bodies."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flex_ident.errors import UsageError
from flex_ident.recording import Floats
from flex_ident.robot.weight import weight_on

GRAVITY = 9.80665


def arm(*, base: str = "0 0 0", axis: str = "0 1 0", extra: str = "") -> str:
    """An arm of two turning joints and a slider, every origin and body turned."""
    return f"""<robot name="arm">
      <link name="world"/>
      <joint name="mount" type="fixed"><parent link="world"/><child link="base"/>
        <origin rpy="{base}" xyz="0 0 1"/></joint>
      <link name="base"><inertial><mass value="50"/></inertial></link>
      <joint name="waist" type="revolute"><parent link="base"/><child link="trunk"/>
        <origin xyz="0.1 0 0.2" rpy="0.2 0.1 0.3"/><axis xyz="0 0 2"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/>
      </joint>
      <link name="trunk"><inertial><mass value="20"/><origin xyz="0 0 0.3"/></inertial></link>
      <joint name="shoulder" type="continuous"><parent link="trunk"/><child link="upper"/>
        <origin xyz="0 0.1 0.4" rpy="0.3 0 -0.2"/><axis xyz="{axis}"/></joint>
      <link name="upper"><inertial><mass value="8"/><origin xyz="0.2 0.05 0.1" rpy="0.5 0.4 0.1"/>
        <inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0.02" iyz="0.0"/></inertial></link>
      <joint name="slide" type="prismatic"><parent link="upper"/><child link="fore"/>
        <origin xyz="0.4 0 0" rpy="0 0.5 0"/><axis xyz="1 0 0"/></joint>
      <link name="fore"><inertial><mass value="3"/><origin xyz="0.1 -0.02 0.03"/>
        <inertia ixx="0.02" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>
      {extra}
    </robot>"""


def _turned(rpy: tuple[float, float, float]) -> Floats:
    return Rotation.from_euler("xyz", rpy).as_matrix()


def _bodies(q: float, waist: float, slide: float, base: tuple[float, float, float], axis: Floats) -> list[Floats]:
    """Centres of upper and fore arm in the world, by hand."""
    at, turn = np.array([0.0, 0.0, 1.0]), _turned(base)
    at, turn = at + turn @ [0.1, 0.0, 0.2], turn @ _turned((0.2, 0.1, 0.3)) @ _turned((0.0, 0.0, waist))
    at, turn = (
        at + turn @ [0.0, 0.1, 0.4],
        turn @ _turned((0.3, 0.0, -0.2)) @ Rotation.from_rotvec(q * axis).as_matrix(),
    )
    upper = at + turn @ [0.2, 0.05, 0.1]
    at, turn = at + turn @ [0.4, 0.0, 0.0], turn @ _turned((0.0, 0.5, 0.0))
    return [upper, at + turn @ np.array([slide + 0.1, -0.02, 0.03])]


@pytest.mark.parametrize("base", [(0.0, 0.0, 0.0), (math.pi / 2, 0.0, 0.0), (math.pi, 0.3, -0.7)])
@pytest.mark.parametrize("direction", [(0.0, 1.0, 0.0), (1.0, 2.0, -1.0)])
def test_gravity_is_the_slope_of_the_potential_at_every_position(
    base: tuple[float, float, float], direction: tuple[float, float, float]
) -> None:
    axis = np.array(direction) / np.linalg.norm(direction)
    text = arm(base=" ".join(map(str, base)), axis=" ".join(map(str, direction)))
    found = weight_on(text, "shoulder", {"waist": 0.4, "slide": 0.15})

    def potential(q: float) -> float:
        return GRAVITY * sum(m * c[2] for m, c in zip((8.0, 3.0), _bodies(q, 0.4, 0.15, base, axis), strict=True))

    for q in (-2.0, -0.3, 0.0, 0.7, 3.0):
        slope = (potential(q + 1e-5) - potential(q - 1e-5)) / 2e-5
        assert GRAVITY * (found.MX * math.cos(q) + found.MY * math.sin(q)) == pytest.approx(slope, abs=1e-6)


def test_the_inertia_is_that_of_all_that_lies_behind() -> None:
    text = """<robot name="r"><link name="a"/><link name="b"><inertial><mass value="2"/><origin xyz="0.3 0 5"/>
      <inertia ixx="9" iyy="9" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
      <joint name="f" type="fixed"><parent link="b"/><child link="c"/><origin xyz="0 0.5 0"/></joint>
      <link name="c"><inertial><mass value="4"/></inertial></link></robot>"""
    found = weight_on(text, "j", {})
    assert found.inertia == pytest.approx(0.1 + 2.0 * 0.09 + 4.0 * 0.25)
    assert found.MX == found.MY == pytest.approx(0.0)  # it turns about the vertical
    assert found.assumed == ()


def test_what_was_not_recorded_counts_as_zero_and_is_told() -> None:
    found = weight_on(arm(), "shoulder", {"slide": 0.1}, moving=("slide",))
    assert found.assumed == ("waist",)
    assert found.moving == ("slide",)
    there = weight_on(arm(), "shoulder", {"slide": 0.1, "waist": 0.0})
    assert (found.MX, found.MY) == (there.MX, there.MY)
    assert weight_on(arm(), "waist", {"shoulder": 0.2, "slide": 0.1}).assumed == ()


def test_a_joint_that_follows_another_is_where_that_leads_it() -> None:
    led = """<joint name="led" type="revolute"><parent link="fore"/><child link="hand"/><axis xyz="0 1 0"/>
      <mimic joint="waist" multiplier="2" offset="0.1"/></joint>
      <link name="hand"><inertial><mass value="1"/><origin xyz="0.2 0 0"/></inertial></link>"""
    free = led.replace('<mimic joint="waist" multiplier="2" offset="0.1"/>', "")
    own = weight_on(arm(extra=led), "shoulder", {"waist": 0.4, "slide": 0.0})
    same = weight_on(arm(extra=free), "shoulder", {"waist": 0.4, "slide": 0.0, "led": 0.9})
    assert (own.MX, own.MY, own.inertia) == pytest.approx((same.MX, same.MY, same.inertia))


CIRCLE = """<joint name="a" type="revolute"><parent link="p"/><child link="q"/></joint>
  <joint name="b" type="fixed"><parent link="q"/><child link="p"/></joint><link name="q"><inertial><mass value="1"/>
  </inertial></link>"""


@pytest.mark.parametrize(
    ("text", "joint", "said"),
    [
        ("", "a", "not XML"),
        ("<robot>", "a", "not XML"),
        ("<xml/>", "a", "expected <robot>"),
        ("<robot/>", "a", "none that moves"),
        ("<robot>" + "x" * (5 << 20) + "</robot>", "a", "characters"),
        (arm(), "elbow", "it has waist, shoulder, slide"),
        (arm(), "slide", "is prismatic"),
        (arm(), "mount", "is fixed"),
        (arm().replace('"0.1 0 0.2"', '"0.1 0"'), "waist", "three numbers"),
        (arm().replace('"0.1 0 0.2"', '"0.1 0 nan"'), "waist", "three numbers"),
        (arm().replace('value="8"', 'value="heavy"'), "waist", "'heavy' for a number"),
        (arm().replace('value="8"', 'value="-8"'), "waist", "mass of -8 kg"),
        (arm().replace('type="continuous"', 'type="ball"'), "waist", "of type 'ball'"),
        (arm(axis="0 0 0"), "waist", "no axis"),
        (arm().replace('<parent link="trunk"/>', ""), "waist", "no <parent"),
        (arm().replace('child link="fore"', 'child link="upper"'), "waist", "on two joints"),
        (arm().replace('name="slide"', 'name="waist"'), "waist", "twice"),
        (f"<robot>{CIRCLE}</robot>", "a", "circle"),
        (arm().replace("mass value", "mass weight"), "waist", "nothing behind"),
    ],
)  # fmt: skip
def test_what_is_no_description_gets_one_line(text: str, joint: str, said: str) -> None:
    with pytest.raises(UsageError, match=said) as caught:
        weight_on(text, joint, {})
    assert "\n" not in str(caught.value).strip()
    assert len(str(caught.value)) < 400
