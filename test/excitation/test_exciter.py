"""The exciter's rules, sample by sample."""

import math
from dataclasses import replace

import numpy as np
import pytest
from servo import CHIRP, GRAVITY, LIMITS, RATE_HZ, commands_stay_inside, servo, started

from flex_ident.errors import ConfigurationError
from flex_ident.excitation import Exciter, ExciterSettings, Gains, JointSample, Limits, chirp_reference
from flex_ident.excitation.commands import INTERFACES


@pytest.mark.parametrize("interface", ["position", "velocity"])
def test_a_whole_run(interface: str) -> None:
    made = started(interface=interface, start_position=0.2)
    output = made.run(8.0)
    assert output.state == "done"
    assert made.states == ["idle", "moving_to_start", "exciting", "ramping_down", "done"]
    assert made.position == pytest.approx(0.2, abs=0.03)
    assert output.others == ((0.7,) if interface == "position" else (0.0,))
    assert output.progress == 1.0
    commands_stay_inside(made)


def test_a_whole_run_under_effort_commands() -> None:
    made = started(interface="effort", gains=Gains(100.0, 10.0, (30.0,), (3.0,)))
    output = made.run(8.0)
    assert output.state == "done", output.reason
    exciting = [o for _, o in made.outputs if o.state == "exciting"]
    assert np.std([o.position for o in exciting]) > 0.01
    assert output.command == pytest.approx(GRAVITY)
    assert output.others == (2.0,)
    commands_stay_inside(made)


@pytest.mark.parametrize("change", [{"effort": math.nan}, {"others_effort": ()}])
def test_an_effort_that_is_not_measured_is_not_carried_on(change: dict[str, object]) -> None:
    made = servo(interface="effort")
    made.exciter.observe(replace(JointSample(made.now, made.now, 0.0, 0.0, GRAVITY, (0.7,), (0.0,), (2.0,)), **change))
    assert "which command.carry_effort would go on with" in made.exciter.objection(made.now)


def test_effort_returns_without_a_step_to_what_held_before() -> None:
    made = started(interface="effort", gains=Gains(100.0, 10.0, (30.0,), (3.0,)))
    made.run(2.0)
    made.exciter.stop("enough")
    made.run(1.5)
    given = made.commands()
    assert np.abs(np.diff(given[-700:])).max() < 0.5
    assert given[-1] == pytest.approx(GRAVITY)


def test_a_robot_that_bears_its_gravity_is_commanded_none() -> None:
    made = started(interface="effort", carry_effort=False)
    assert made.tick().command == pytest.approx(0.0, abs=1e-9)
    assert made.tick().others == (0.0,)


def test_other_joints_are_held_under_effort_commands() -> None:
    made = started(interface="effort", held_effort=(20.0,))
    made.run(0.5)
    made.sample = lambda s: replace(s, others=(0.68,), others_velocity=(0.2,))
    assert made.tick().others[0] == pytest.approx(2.0 + 30.0 * 0.02 - 3.0 * 0.2)
    made.sample = lambda s: replace(s, others_velocity=(-100.0,))
    assert made.tick().others[0] == 20.0


def test_a_joint_that_shall_hold_and_does_not_ends_the_run() -> None:
    made = started()
    made.run(1.5)
    begin = made.now
    made.sample = lambda s: replace(s, others=(0.7 + 0.5 * min(1.0, made.now - begin),))
    output = made.run(1.0)
    assert output.state == "aborted"
    assert "which shall hold, is 0.201 rad away from where it was" in output.reason


def test_a_joint_that_drifts_without_a_velocity_reading_is_seen_to_move() -> None:
    made = servo()
    exciter = made.exciter
    for k in range(200):
        now = made.now + 0.002 * k
        exciter.observe(JointSample(now, now, 0.06 * 0.002 * k, others=(0.7,)))
    assert "moves at 0.06 rad/s: let it come to rest" in exciter.objection(now)


def test_effort_commands_need_gains_for_the_joints_that_hold() -> None:
    made = servo(interface="effort", gains=Gains(5.0, 0.0))
    assert "one of each for the 1 other joints" in made.exciter.start(made.now)
    assert made.exciter.state == "idle"


@pytest.mark.parametrize(
    ("kwargs", "text"),
    [
        ({"position": 0.45}, "reduce chirp.amplitude to"),
        ({"position": 0.8}, "move it inside"),
        ({"start_position": 0.6}, "start_position 0.6 rad cannot be reached, allowed are -0.5 to 0.5"),
        ({"limits": replace(LIMITS, velocity=0.1)}, "allowed are 0.1 rad/s"),
        ({"limits": replace(LIMITS, effort=0.5)}, "exerts 1 N m at rest, allowed are 0.5"),
        ({"chirp": replace(CHIRP, end_frequency_hz=80.0)}, "carry up to 50 Hz: raise rate_hz to 800"),
        ({"inertia": 100.0}, "allowed are 50 N m"),
        ({"limits": Limits(velocity=1.0)}, "limits.position_min, limits.position_max not known"),
        ({"limits": replace(LIMITS, velocity=math.inf)}, "limits.velocity not known"),
        ({"limits": replace(LIMITS, effort=math.inf), "interface": "effort"}, "limits.effort not known"),
    ],
)
def test_refusals_say_the_number_and_the_fix(kwargs: dict[str, object], text: str) -> None:
    made = servo(**kwargs)
    assert text in made.exciter.start(made.now)
    made.run(0.2)
    assert made.commands() == []


@pytest.mark.parametrize(
    ("limits", "key"), [(replace(LIMITS, position_max=0.06), "position"), (replace(LIMITS, velocity=0.2), "velocity")]
)
def test_the_reduction_that_a_refusal_names_is_enough(limits: Limits, key: str) -> None:
    made = servo(limits=limits)
    percent = float(made.exciter.start(made.now).split("reduce chirp.amplitude to ")[1].split(" %")[0])
    chirp = replace(CHIRP, amplitude=CHIRP.amplitude * (percent - 0.5) / 100.0)
    made = servo(limits=limits, chirp=chirp)
    assert made.exciter.start(made.now) == "", key


def test_refuses_without_fresh_states_of_the_joint() -> None:
    exciter = Exciter(ExciterSettings("elbow", held=("wrist",)), chirp_reference(CHIRP), LIMITS)
    assert "no joint states" in exciter.start(0.0)
    exciter.observe(JointSample(0.0, 0.0, None, names=("arm_1", "arm_2")))
    assert "not in the joint states, which hold arm_1, arm_2" in exciter.start(0.0)
    exciter.observe(JointSample(0.0, 0.0, math.nan, others=(0.0,)))
    assert "nan" in exciter.start(0.0)
    exciter.observe(JointSample(0.1, 0.1, 0.0, others=(0.0,)))
    assert "2.90 s old, 0.10 s allowed" in exciter.start(3.0)
    exciter.observe(JointSample(3.0, 3.0, 0.0, velocity=0.5, others=(0.0,)))
    assert "let it come to rest" in exciter.start(3.0)
    exciter.observe(JointSample(3.0, 3.0, 0.0, others=(math.nan,)))
    assert "'wrist' of command.joints has no position" in exciter.start(3.0)


def test_two_starts_and_a_stop_before_a_start() -> None:
    made = servo()
    assert "nothing to stop" in made.exciter.stop("x")
    assert made.exciter.start(made.now) == ""
    made.run(0.2)
    assert "already moving to start" in made.exciter.start(made.now)


def test_a_second_run_begins_anew() -> None:
    made = started()
    made.run(7.0)
    assert made.exciter.state == "done"
    assert made.exciter.start(made.now) == ""
    assert made.tick().progress == 0.0
    assert made.run(7.0).state == "done"
    commands_stay_inside(made)


class Frozen:
    """The first sample again and again, received anew; with `again` its stamp too."""

    def __init__(self, *, again: bool = False) -> None:
        self.first: JointSample | None = None
        self.again = again

    def __call__(self, sample: JointSample) -> JointSample:
        self.first = self.first or sample
        return replace(self.first, received=sample.received, stamp=(self.first if self.again else sample).stamp)


class Pushed:
    """A joint that is pushed away at the given speed, rad/s."""

    def __init__(self, speed: float) -> None:
        self.speed, self.since = speed, 0.0

    def __call__(self, sample: JointSample) -> JointSample:
        self.since = self.since or sample.received
        return replace(sample, position=sample.position + self.speed * (sample.received - self.since))


FAULTS = {
    "nan": (lambda s: replace(s, position=math.nan), "position of 'elbow' is nan"),
    "nan_velocity": (lambda s: replace(s, velocity=math.nan), "velocity of 'elbow' is nan"),
    "inf_effort": (lambda s: replace(s, effort=math.inf), "effort of 'elbow' is inf"),
    "lost": (lambda s: replace(s, position=None, names=("wrist",)), "vanished"),
    "stopped": (lambda s: None, "no joint state"),
    "time_jump": (lambda s: replace(s, stamp=s.stamp + 5.0), "jumps by +5.0"),
    "time_back": (lambda s: replace(s, stamp=s.stamp - 5.0), "jumps by -"),
    "elsewhere": (lambda s: replace(s, position=0.4), "position of 'elbow' jumps by"),
    "wrapped": (lambda s: replace(s, position=s.position - math.tau), "a whole turn: it wraps"),
    "other_elsewhere": (lambda s: replace(s, others=(0.2,)), "position of a joint that shall hold jumps by -0.5 rad"),
    "other_nan": (lambda s: replace(s, others=(math.nan,)), "position of 'shoulder', which shall hold, is nan"),
    "fast": (lambda s: replace(s, velocity=1.5), "speed, 1.5 rad/s, exceeds 1"),
    "strong": (lambda s: replace(s, effort=80.0), "effort, 80 N m, exceeds 50"),
}


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize("fault", [*FAULTS, "frozen", "repeated"])
@pytest.mark.parametrize("after_s", [0.5, 1.6, 3.0])
def test_a_fault_ramps_down_and_says_why(fault: str, interface: str, after_s: float) -> None:
    made = started(interface=interface, start_position=0.1, gains=Gains(60.0, 10.0, (30.0,), (3.0,)))
    made.run(after_s)
    if fault in FAULTS:
        made.sample, text = FAULTS[fault]
    else:
        made.sample, text = {
            "frozen": (Frozen(), "though their stamps go on"),
            "repeated": (Frozen(again=True), "with the same stamp again and again"),
        }[fault]
    made.run(4.0)
    assert made.exciter.state == "aborted"
    assert text in made.exciter.reason
    commands_stay_inside(made)
    assert len(set(made.commands()[-200:])) == 1  # held, not moving


@pytest.mark.parametrize(
    ("interface", "tracking_error", "text"),
    [
        ("position", 0.2, "the tracking error, 0.2"), ("velocity", 0.2, "the tracking error, 0.2"),
        ("position", 5.0, "has left -0.5 to 0.5"),
    ],
)  # fmt: skip
def test_a_joint_that_is_pushed_away_ends_the_run(interface: str, tracking_error: float, text: str) -> None:
    limits = replace(LIMITS, tracking_error=tracking_error, velocity=2.0)
    made = started(interface=interface, limits=limits)
    made.run(2.0)
    made.sample = Pushed(3.0)
    made.run(5.0)
    assert made.exciter.state == "aborted"
    assert text in made.exciter.reason
    commands_stay_inside(made, limits)


@pytest.mark.parametrize("interface", ["velocity", "effort"])
@pytest.mark.parametrize("fault", ["wrapped", "frozen", "nan", "lost", "stopped", "time_jump"])
def test_feedback_that_is_known_to_be_wrong_moves_nothing(interface: str, fault: str) -> None:
    """What is commanded after the fault goes to what held the joint, never the way that the wrong feedback pulls."""
    made = started(interface=interface, gains=Gains(100.0, 10.0, (30.0,), (3.0,)))
    made.run(2.0)
    made.sample = Frozen() if fault == "frozen" else FAULTS[fault][0]
    made.run(0.2)
    rest = GRAVITY if interface == "effort" else 0.0
    held = abs(made.commands()[-1] - rest)
    before = len(made.outputs)
    largest = max(abs(c - rest) for c in made.commands()[: -round(0.2 * RATE_HZ)])
    made.run(2.0)
    after = [o.command - rest for _, o in made.outputs[before:]]
    assert made.exciter.state == "aborted"
    assert max(map(abs, after)) <= max(held, largest)
    assert after[-1] == pytest.approx(0.0)
    assert abs(made.position) < 0.4


@pytest.mark.parametrize("interface", ["velocity", "effort"])
def test_a_continuous_joint_goes_on_where_its_reading_wraps(interface: str) -> None:
    made = servo(interface=interface, position=math.pi - 0.01, limits=Limits(-4.0, 4.0, 1.0, 50.0, 0.2),
                 gains=Gains(100.0, 10.0, (30.0,), (3.0,)), continuous=(True, True))  # fmt: skip
    made.sample = lambda s: replace(s, position=math.remainder(s.position, math.tau))
    made.tick()
    assert made.exciter.start(made.now) == ""
    made.run(8.0)
    assert made.exciter.state == "done", made.exciter.reason
    assert made.position == pytest.approx(math.pi, abs=0.15)


def test_positions_of_a_joint_without_end_are_not_commanded_past_a_half_turn() -> None:
    limits = Limits(-4.0, 4.0, 1.0, 50.0, 0.2)
    made = servo(position=math.pi - 0.01, limits=limits, continuous=(True,))
    assert "passes a half turn" in made.exciter.objection(made.now)
    assert servo(position=math.pi - 0.01, limits=limits).exciter.objection(made.now) == ""
    assert servo(position=1.0, limits=limits, continuous=(True,)).exciter.objection(made.now) == ""


@pytest.mark.parametrize(("interface", "gap_s"), [("position", 1.1), ("velocity", 0.13), ("effort", 0.13)])
def test_an_exciter_that_stood_still_for_too_long_moves_nothing_any_more(interface: str, gap_s: float) -> None:
    made = started(interface=interface)
    made.run(2.0)
    last = made.commands()[-1]
    made.now += gap_s
    output = made.tick()
    assert output.state == "aborted"
    assert "stood still" in output.reason
    assert output.command == pytest.approx({"position": last, "velocity": 0.0, "effort": GRAVITY}[interface])
    assert output.left == (interface == "effort"), "the guard holds the joint by then"


def test_silence_while_the_exciter_itself_stood_still_is_told_as_that() -> None:
    made = started()
    made.run(2.0)
    made.now += 0.3
    made.exciter.step(made.now)
    assert "this node stood still for 0.30 s" in made.exciter.reason


def test_readings_that_come_later_and_later_are_no_fresh_ones() -> None:
    made = started()
    made.run(2.0)
    begin = made.now
    made.sample = lambda s: replace(s, stamp=s.stamp - min(0.5 * (made.now - begin), 0.3))
    made.run(1.0)
    assert "behind, 0.100 s allowed" in made.exciter.reason


def test_readings_that_are_old_when_they_come_are_none_to_begin_with() -> None:
    made = servo()
    made.sample = lambda s: replace(s, age=0.55)
    made.tick()
    assert "0.55 s old when they come" in made.exciter.objection(made.now)
    made.sample = lambda s: replace(s, age=1e6)  # another clock altogether
    made.tick()
    assert made.exciter.objection(made.now) == ""


def test_a_gripper_on_the_same_topic_is_no_fault() -> None:
    made = started()
    for k in range(round(7.0 * RATE_HZ)):
        if k % 3 == 0:
            made.exciter.observe(JointSample(made.now, made.now - 0.3, None, names=("finger",)))
        made.tick()
    assert made.exciter.state == "done"


def test_readings_that_a_robot_never_gives_are_no_fault() -> None:
    made = servo()
    made.sample = lambda s: replace(s, velocity=math.nan, effort=math.nan)
    made.tick()
    assert made.exciter.start(made.now) == ""
    assert made.run(7.0).state == "done"


def test_a_joint_that_sticks_for_a_while_is_not_frozen() -> None:
    made = started(chirp=replace(CHIRP, amplitude=1e-3))
    made.sample = lambda s: replace(s, position=4e-4 * round((s.position or 0.0) / 4e-4), velocity=0.0)
    assert made.run(7.0).state == "done"


def test_a_controller_that_ignores_commands_is_found_out() -> None:
    made = started()
    made.sample = lambda s: replace(s, position=0.0, velocity=0.0, effort=made.now % 1.0)
    made.run(4.0)
    assert made.exciter.state == "aborted"
    assert "the joint does not follow: it moved 0 rad" in made.exciter.reason


def test_frozen_readings_are_found_at_the_smallest_amplitude() -> None:
    made = started(chirp=replace(CHIRP, amplitude=1e-3))
    made.run(2.0)
    made.sample = Frozen()
    made.run(1.5)
    assert "frozen" in made.exciter.reason


def test_what_is_in_the_way_is_not_pushed_for_long() -> None:
    made = started(start_position=0.3, limits=replace(LIMITS, tracking_error=0.05))
    made.sample = lambda s: replace(s, position=min(s.position or 0.0, 0.1), velocity=0.0, effort=made.now % 1.0)
    made.run(5.0)
    assert "tracking error" in made.exciter.reason
    assert made.exciter.state == "aborted"
    assert made.commands()[-1] == pytest.approx(0.1)
    commands_stay_inside(made)


def test_a_start_position_that_the_joint_does_not_get_to_aborts() -> None:
    made = started(start_position=0.3)
    made.sample = lambda s: replace(s, position=min(s.position or 0.0, 0.2), velocity=0.0, effort=made.now % 1.0)
    made.run(8.0)
    assert made.exciter.state == "aborted"
    assert "0.3 rad was not reached: at 0.2 rad" in made.exciter.reason
    commands_stay_inside(made)


def test_a_late_tick_skips_and_never_stretches() -> None:
    made = started()
    made.run(1.5)
    assert made.exciter.state == "exciting"
    begin = made.now
    progress = made.outputs[-1][1].progress
    made.tick(0.05)
    made.tick()
    assert made.outputs[-1][1].progress == pytest.approx(progress + (made.now - begin) / 4.0, abs=1e-9)
    commands_stay_inside(made)


@pytest.mark.parametrize("stall_s", [0.02, 0.06, 0.09])
def test_what_a_late_tick_missed_is_caught_up_with_in_steps(stall_s: float) -> None:
    made = started(limits=replace(LIMITS, tracking_error=0.5))
    made.run(1.5)
    made.tick(stall_s)
    for _ in range(100):
        made.tick()
    given = made.commands()
    assert np.abs(np.diff(given)).max() <= 2.0 * LIMITS.velocity / RATE_HZ + 1e-12
    wanted = made.exciter.reference.at((made.outputs[-1][1].progress) * made.exciter.reference.total_s)[0]
    assert given[-1] == pytest.approx(wanted, abs=1e-6)


def test_what_a_late_tick_missed_on_the_way_to_the_start_is_caught_up_with_gently() -> None:
    made = started(start_position=0.3)
    made.run(1.0)
    made.tick(0.09)
    made.run(2.0)
    assert made.exciter.state == "exciting"
    way = [o.position for _, o in made.outputs if o.state == "moving_to_start"]
    assert np.diff(way).max() <= 2.0 * 1.1 * made.exciter.settings.approach_velocity / RATE_HZ + 1e-12
    assert way[-1] == pytest.approx(0.3, abs=1e-6)


def test_stop_ramps_down_without_a_jump_of_speed() -> None:
    made = started()
    made.run(1.8)
    assert made.exciter.stop("stopped by ~/stop") == ""
    assert made.exciter.stop("again") == ""
    made.run(1.0)
    assert (made.exciter.state, made.exciter.reason) == ("aborted", "stopped by ~/stop")
    given = np.array(made.commands())
    accelerations = np.abs(np.diff(given, 2))[-505:] * RATE_HZ**2
    speed = np.abs(np.diff(given)).max() * RATE_HZ
    assert accelerations.max() < 1.1 * speed * math.pi / 2 / 0.3 + 1.0
    assert "nothing to stop" in made.exciter.stop("again")


@pytest.mark.slow
@pytest.mark.parametrize("interface", ["position", "velocity"])
def test_braking_near_a_bound_stays_inside(interface: str) -> None:
    limits = Limits(-0.055, 0.08, 1.0, 50.0, 0.2)
    for k in range(40):
        made = started(limits=limits, interface=interface)
        made.run(1.4 + 0.02 * k)
        made.exciter.stop("x")
        made.run(0.5)
        commands_stay_inside(made, limits)


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize("seed", range(8))
def test_whatever_comes_in_commands_stay_inside(interface: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    wild = (0.0, math.nan, math.inf, -math.inf, 1e300, -1e9, 0.49, -0.49)
    limits = Limits(-0.07, 0.08, 0.4, 5.0, 0.2)
    made = servo(limits=limits, interface=interface, gains=Gains(1e4, 1e3, (1e4,), (1e3,)), held_effort=(7.0,))

    def disturbed(sample: JointSample) -> JointSample | None:
        if rng.random() < 0.995:
            return sample
        value = float(rng.choice(wild))
        field = rng.choice(["position", "velocity", "effort", "stamp", "others", "none"])
        if field == "none":
            return None
        return replace(sample, **{str(field): (value,) if field == "others" else value})

    runs = 0
    for _ in range(6000):
        if made.exciter.state not in ("moving_to_start", "exciting", "ramping_down"):
            made.position, made.velocity, made.effort = float(rng.uniform(-0.06, 0.07)), 0.0, GRAVITY
            made.sample = lambda s: s
            made.tick()
            made.outputs.clear()
            runs += made.exciter.start(made.now) == ""
            made.sample = disturbed
        if rng.random() < 0.001:
            made.exciter.stop("x")
        made.tick(float(rng.choice([0.002, 0.0021, 0.05], p=[0.9, 0.09, 0.01])))
        if interface == "effort":
            assert all(abs(o) <= 7.0 for o in made.outputs[-1][1].others)
        if made.exciter.state == "aborted":
            commands_stay_inside(made, limits)
    commands_stay_inside(made, limits)
    assert runs > 3


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"joint": ""}, "joint is empty"),
        ({"joint": "a", "rate_hz": 0.0}, "rate_hz"),
        ({"joint": "a", "rate_hz": math.nan}, "rate_hz"),
        ({"joint": "a", "interface": "torque"}, "command.interface"),
        ({"joint": "a", "start_position": math.inf}, "start_position"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings: dict[str, object], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        ExciterSettings(**settings)  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match="velocity_gain"):
        Gains(1.0, -1.0)
