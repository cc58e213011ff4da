"""A guard brakes joints under effort commands by feedback of its own, sample by sample; and what it does without it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from flex_ident.excitation import Gains, JointSample, Limits
from flex_ident.excitation.guarding import HOLD_S, INSIST_S, LONGEST_HOLD_S, Beat, Guarding
from flex_ident.excitation.holding import Hold

LIMITS = Limits(-0.4, 0.4, 2.0, 60.0, 0.2)
GAINS = Gains(300.0, 30.0, (100.0,), (10.0,))
INERTIA, DAMPING, GRAVITY, SLOPE = 1.0, 0.5, 2.0, 5.0
"""Little damping: what is not braked leaves its limits. Gravity, N m, falls with the position, N m/rad."""
JOINTS = ("shoulder", "elbow")
STEP_S = 1e-3
DIED = 100.0
Seen = Callable[[JointSample], JointSample | None]


def hold(*, continuous: tuple[bool, ...] = (), start: float = 0.0) -> Hold:
    """Of a joint that was at rest at `start` rad with 2 N m, beside one at 0.5 rad with 1 N m."""
    at_rest = JointSample(90.0, 90.0, start, 0.0, GRAVITY, (0.5,), (0.0,), (1.0,))
    limits = replace(LIMITS, position_min=start - 0.4, position_max=start + 0.4)
    return Hold("elbow", ("shoulder",), GAINS, limits, at_rest, True, (40.0,), continuous, 0.5)


class Plant:
    """The joints after the exciter's death, and a guard that begins at once or when the lease has run out."""

    def __init__(self, position: float, velocity: float, effort: float, *, given: Hold | None = None) -> None:
        self.position, self.velocity, self.now = position, velocity, DIED
        self.hold = given or hold()
        self.start = self.hold.start.position or 0.0
        self.efforts = [effort]
        self.row = (1.0, effort)
        self.positions: list[float] = []
        self.rules = Guarding()
        self.rules.beat(
            Beat(DIED, True, 0.12, (1.0, GRAVITY), JOINTS, self.hold, (effort, 1.0), position)
        )  # fmt: skip

    def live(self, seconds: float, seen: Seen = lambda sample: sample, *, ended: bool = True) -> None:
        """Let time pass; `seen` is what becomes of the joint states, at 500 Hz."""
        if ended:
            self.rules.gone()
        for k in range(round(seconds / STEP_S)):
            self.now += STEP_S
            if k % 2 == 0:
                sample = seen(
                    JointSample(self.now, self.now, self.position, self.velocity, self.row[1], (0.5,), (0.0,))
                )
                if sample is not None:
                    self.rules.observe(sample)
            due = self.rules.due(self.now)
            if due is not None:
                self.row = due.row
            net = self.row[1] - GRAVITY + SLOPE * (self.position - self.start) - DAMPING * self.velocity
            self.velocity += net / INERTIA * STEP_S
            self.position += self.velocity * STEP_S
            self.efforts.append(self.row[1])
            self.positions.append(self.position)

    @property
    def inside(self) -> bool:
        """Whether the joint never left its limits, nor the effort."""
        limits = self.hold.limits
        reach = limits.position_min <= min(self.positions) and max(self.positions) <= limits.position_max
        return reach and max(map(abs, self.efforts)) <= limits.effort


def test_a_beat_with_what_it_takes_to_hold_goes_over_the_pipe_as_it_is() -> None:
    beat = Beat(1.0, True, 0.1, (1.0, 2.0), JOINTS, hold(), (3.0, 1.0), 0.25)
    read = Beat.read(beat.line())
    assert read.hold is not None
    assert read.hold.text == hold().text
    assert replace(read, hold=None) == replace(beat, hold=None)
    assert math.isinf(read.hold.limits.tracking_error)
    with pytest.raises(ValueError, match="list"):
        Beat.read(b'[1.0,true,0.1,[1.0],["a"],[1.0],0.0]\t[1,2,3,4,5,6,7,8,9]')


@pytest.mark.parametrize(
    ("position", "velocity", "effort"), [(0.0, 1.5, 20.0), (0.25, 1.2, 15.0), (-0.25, -1.2, -15.0)]
)
@pytest.mark.parametrize("ended", [True, False], ids=["killed", "stopped"])
def test_a_joint_that_moves_is_braked_inside_its_limits_and_held_where_it_comes_to_rest(
    position: float, velocity: float, effort: float, ended: bool
) -> None:
    if not ended:
        effort, velocity = GRAVITY, 0.5 * velocity  # what stands for a lease moves the joint on
    plant = Plant(position, velocity, effort)
    plant.live(INSIST_S + 1.0, ended=ended)
    assert plant.inside, (min(plant.positions), max(plant.positions))
    assert abs(plant.velocity) < 1e-3
    assert plant.rules.finished(plant.now) == ended
    rest, last = plant.position, plant.row
    plant.live(3.0, lambda _: None, ended=ended)
    assert plant.row == last, "it goes on commanding"
    assert plant.position == pytest.approx(rest, abs=0.01)
    assert last[1] == pytest.approx(GRAVITY - SLOPE * rest, abs=0.2), "not the effort that holds the joint here"


def test_without_feedback_it_would_have_left_them() -> None:
    plant = Plant(0.25, 1.2, 15.0)
    plant.live(INSIST_S, lambda _: None)
    assert not plant.inside


def test_the_guard_does_nothing_while_the_exciter_lives() -> None:
    plant = Plant(0.0, 1.5, 20.0)
    for k in range(50):
        now = DIED + 0.002 * k
        plant.rules.beat(replace(Beat(now, True, 0.12, (1.0, GRAVITY), JOINTS), hold=plant.hold, standing=(5.0, 1.0)))
        plant.rules.observe(JointSample(now, now, 0.0))
        assert plant.rules.due(now + 0.1) is None


@pytest.mark.parametrize(
    ("name", "seen"),
    [
        ("no states", lambda _: None),
        ("nan", lambda s: replace(s, position=math.nan)),
        ("inf", lambda s: replace(s, position=math.inf)),
        ("frozen", lambda s: replace(s, position=0.1, velocity=1.5, effort=20.0)),
        ("far from where it was", lambda s: replace(s, position=s.position + 2.0)),
        ("without the joint", lambda s: replace(s, position=None, names=("gripper",))),
        ("backwards in time", lambda s: replace(s, stamp=-s.stamp)),
        ("other joint not a number", lambda s: replace(s, others=(math.nan,), others_velocity=(math.nan,))),
    ],
)
def test_readings_that_are_not_to_be_believed_are_not_acted_on_for_long(name: str, seen: Seen) -> None:
    plant = Plant(0.1, 1.5, 20.0)
    plant.live(0.7, seen)
    assert max(map(abs, plant.efforts)) <= 25.0
    if name != "other joint not a number":
        assert plant.row == pytest.approx((1.0, GRAVITY), abs=0.1), "it has not faded to what held the joints"
    else:
        assert all(map(math.isfinite, plant.row))


@pytest.mark.parametrize("what", ["nan", "jump"])
def test_readings_that_go_wrong_while_it_brakes_are_believed_no_more(what: str) -> None:
    plant = Plant(0.0, 1.5, 20.0)
    plant.live(0.1)
    plant.live(0.02, lambda s: replace(s, position=math.nan if what == "nan" else s.position + 0.3))
    plant.live(1.0)
    assert plant.row == pytest.approx((1.0, GRAVITY), abs=0.1)
    assert max(map(abs, plant.efforts)) <= LIMITS.effort


def test_what_the_exciter_did_not_believe_its_guard_does_not() -> None:
    plant = Plant(0.0, 0.0, 20.0)
    plant.rules.beat(Beat(DIED, True, 0.12, (1.0, GRAVITY), JOINTS, plant.hold, (20.0, 1.0), None))
    plant.live(INSIST_S + 0.5)
    assert plant.row == pytest.approx((1.0, GRAVITY), abs=0.01)
    assert plant.rules.finished(plant.now)


def test_a_joint_whose_reading_wraps_is_held_across_the_wrap() -> None:
    start = math.pi - 0.05
    plant = Plant(start, 1.0, GRAVITY, given=hold(continuous=(True, False), start=start))

    def wrapped(s: JointSample) -> JointSample:
        assert s.position is not None
        return replace(s, position=math.remainder(s.position, math.tau))

    plant.live(INSIST_S + 1.0, wrapped)
    assert plant.positions[-1] > math.pi + 0.01
    assert plant.inside
    assert abs(plant.velocity) < 1e-3
    assert max(map(abs, plant.efforts)) < 30.0


def test_a_joint_that_does_not_come_to_rest_is_held_no_longer_than_that() -> None:
    plant = Plant(0.0, 0.0, GRAVITY)
    plant.live(LONGEST_HOLD_S - 0.5, lambda s: replace(s, velocity=0.2 * math.sin(40.0 * s.stamp)))
    assert not plant.rules.finished(plant.now)
    assert plant.rules.wait_s(plant.now) == HOLD_S
    plant.live(1.0, lambda s: replace(s, velocity=0.2 * math.sin(40.0 * s.stamp)))
    assert plant.rules.finished(plant.now)
