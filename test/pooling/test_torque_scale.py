"""The effort's scale by a known mass: found, covered, and refused where the mass says nothing."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drawn import KEYS, members

from flex_ident.errors import UsageError
from flex_ident.jobs.payloads import loads_in
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Covariance
from flex_ident.pooling.members import Member, side_by_side
from flex_ident.pooling.several import several
from flex_ident.pooling.torque_scale import Load, TorqueScale, torque_scale
from flex_ident.report.sentences import sentence

LOADS = [Load(), Load(5.0, 0.4)]
"""0.8 kg m^2: half of the link's own inertia."""


def added(loads: list[Load], turned: float = 0.0, gravity: float = 1.0) -> np.ndarray:
    """What the loads add to the drawn parameters, their frame turned; `gravity` is what counts of their weight."""
    found = np.zeros((len(loads), len(KEYS)))
    for row, load in zip(found, loads, strict=True):
        row[KEYS.index("JL")] = load.inertia
        mx, my = load.mass * load.x, load.mass * load.y
        row[KEYS.index("MX")] = gravity * (mx * np.cos(turned) - my * np.sin(turned))
        row[KEYS.index("MY")] = gravity * (my * np.cos(turned) + mx * np.sin(turned))
    return found


def scales(
    loads: list[Load], draws: int, seed: int, *, own: float = 0.5, **given: float
) -> list[tuple[float, TorqueScale]]:
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(draws):
        true = float(rng.uniform(0.8, 1.2))
        drawn = members(rng, len(loads), scale=true, added=added(loads, **given), own=own)
        found.append((true, torque_scale(side_by_side(drawn), loads)))
    return found


@pytest.mark.parametrize("loads", [LOADS, [Load(), Load(), Load(3.0, 0.4), Load(5.0, 0.3, 0.2)]], ids=["two", "four"])
@pytest.mark.parametrize("turned", [0.0, 1.0])
def test_it_is_found_and_covered_by_each_and_by_both(loads: list[Load], turned: float) -> None:
    found = scales(loads, 300, 21, turned=turned)
    assert all(s.both is not None for _, s in found)
    for part in ("both", "inertia", "gravity"):
        known = [(t, getattr(s, part)) for t, s in found if getattr(s, part) is not None]
        inside = np.mean([own.low <= true <= own.high for true, own in known])
        assert 0.91 <= inside <= 0.995, part
    errors = [abs(s.both.value / true - 1.0) for true, s in found if s.both is not None]
    assert np.median(errors) < 0.005
    assert np.percentile(errors, 95) < 0.01
    assert np.mean([s.agree is False for _, s in found]) < 0.03
    assert np.median([s.angle for _, s in found]) == pytest.approx(turned, abs=0.05)


@pytest.mark.parametrize(
    ("loads", "outcome"),
    [([Load(), Load(5.0)], "on_axis"), ([Load(5.0, 0.4)] * 2, "same_loads"), ([Load()] * 2, "same_loads"),
     ([Load(), Load(0.05, 0.2)], "weak")],
)  # fmt: skip
def test_it_is_not_told_where_the_mass_says_nothing(loads: list[Load], outcome: str) -> None:
    for _, found in scales(loads, 10, 22):
        assert found.outcome == outcome
        assert found.both is None


def test_a_weight_that_does_not_pull_is_told_from_one_that_does() -> None:
    found = scales(LOADS, 100, 23, gravity=0.9)
    assert np.mean([s.agree is False for _, s in found]) > 0.9
    assert all(
        s.both is not None and s.inertia is not None and s.both.low < s.inertia.value < s.both.high
        for _, s in found if s.agree is False
    )  # fmt: skip


def test_what_the_recordings_share_does_not_hide_the_weight_that_was_added() -> None:
    """First moments that a cable may be in by two fifths, the same in both: their difference is the mass's."""
    for seed in range(10):
        drawn = members(np.random.default_rng((29, seed)), 2, scale=1.1, added=added(LOADS))
        apart = [_with_shared(m, {"MX": 0.2, "MY": 1.2}) for m in drawn]
        one, other = (torque_scale(side_by_side(d), LOADS).gravity for d in (drawn, apart))
        assert one is not None
        assert other is not None
        assert (other.value, other.std) == pytest.approx((one.value, one.std), rel=1e-6)


def _with_shared(member: Member, shared: dict[str, float]) -> Member:
    known = member.covariance
    more = np.array([shared.get(key, 0.0) for key in known.keys])
    matrix = known.matrix + np.diag(more**2)
    systematic = np.hypot(known.systematic, more)
    return replace(member, covariance=Covariance(known.keys, matrix, systematic))


def test_friction_is_not_mixed_up_with_the_scale() -> None:
    rng = np.random.default_rng(24)
    more = np.zeros((2, len(KEYS)))
    more[1, [KEYS.index(k) for k in ("FVm", "FSm", "FV")]] = 0.5  # the load makes friction grow by half
    drawn = members(rng, 2, scatter=more, added=added(LOADS), scale=1.1, own=0.2)
    found = torque_scale(side_by_side(drawn), LOADS)
    assert found.both is not None
    assert found.both.value == pytest.approx(1.1, rel=0.005)


def test_a_slide_weighs_what_it_carries() -> None:
    drawn = members(np.random.default_rng(25), 2, added=np.array([[0.0] * 8, [0, 0, 5.0, 0, 0, 0, 0, 0]]), scale=0.9)
    found = torque_scale(side_by_side(drawn), [Load(), Load(5.0)], slides=True)
    assert found.both is not None
    assert found.both.value == pytest.approx(0.9, rel=0.02)


def test_a_current_becomes_a_torque_and_the_mass_is_taken_off_again() -> None:
    loads = [Load(), Load(5.0, 0.4), Load(5.0, 0.2, 0.2)]
    inside = dict.fromkeys(("Jm", "JL", "K"), 0)
    truth = {"Jm": 1.0, "JL": 1.6, "K": 1.0e4}
    for seed in range(100):
        drawn = members(np.random.default_rng((26, seed)), 3, added=added(loads), scale=12.5)
        found = several(drawn, loads, current=True)
        assert found.multiplied == pytest.approx(12.5, rel=0.03)
        for p in found.parameters:
            if p.key in inside:
                inside[p.key] += p.interval[0] <= truth[p.key] <= p.interval[1]
    assert min(inside.values()) >= 90
    plain = several(members(np.random.default_rng(27), 3, added=added(loads), scale=1.1), loads)
    assert plain.multiplied == 1.0
    assert plain.verdict == "doubtful"
    assert [n.code for n in plain.notices if n.severity == "doubt"] == ["torque_scale_off"]


NAMES = [("a", "bags/a"), ("b", "bags/b")]


def test_payloads_are_read_by_bag_and_for_all() -> None:
    assert loads_in([], NAMES) is None
    assert loads_in(["b=5.0@0.40"], NAMES) == [Load(), Load(5.0, 0.4)]
    assert loads_in(["bags/b=5@0.4,-0.1", "2@0.1"], NAMES) == [Load(2.0, 0.1), Load(5.0, 0.4, -0.1)]


@pytest.mark.parametrize(
    ("texts", "said"),
    [(["c=5@0.4"], "none of the recordings: a, b"),
     (["5"], "expected"), (["b=x@1"], "expected"), (["b=5@"], "expected"),
     (["b=5@1", "b=4@1"], "second one"), (["5@1", "4@1"], "second one"), (["b=-5@1"], "expected a mass"),
     (["b=nan@1"], "expected a mass"), (["b=5@inf"], "expected a mass"), (["=5@1"], "expected")],
)  # fmt: skip
def test_payloads_that_are_none_are_refused_by_name(texts: list[str], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        loads_in(texts, NAMES)


def test_a_mass_of_zero_is_refused_but_beside_one_for_all_others() -> None:
    with pytest.raises(UsageError, match="no recording carries a mass"):
        loads_in(["b=0@0.4"], NAMES)
    with pytest.raises(UsageError, match="a mass of 0 kg is what a recording without --payload carries"):
        loads_in(["a=5@0.4", "b=0@0.4"], NAMES)
    assert loads_in(["5@0.4", "b=0@0.4"], NAMES) == [Load(5.0, 0.4), Load(0.0, 0.4)]


def test_x_and_y_exchanged_are_asked_for() -> None:
    numbers = {"scale": 1.0, "two_std": 0.01, "inertia": 1.0, "weight": 1.0, "least_deg": 5.0}
    for angle, asked in ((-88.0, True), (30.0, False), (2.0, False)):
        text = sentence(Notice(Code.TORQUE_SCALE, "motor_torque", {**numbers, "angle_deg": angle}))
        assert ("exchanged" in text) is asked


def test_a_label_on_the_wrong_recording_is_asked_for() -> None:
    """The mass was in the other of two bags: its gravity acted as if turned by 180 degrees, and that was all that was
    said."""
    numbers = {"scale": 1.0, "two_std": 0.01, "inertia": math.nan, "weight": 1.0, "least_deg": 5.0, "angle_deg": -179.0}
    assert "in the other recordings" in sentence(Notice(Code.TORQUE_SCALE, "motor_torque", numbers))
