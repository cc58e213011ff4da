"""The exciter's rules, sample by sample, on a joint that follows its command as a servo does."""

import itertools
import math
from dataclasses import replace

import pytest

from flex_ident.excitation import ChirpSettings, Exciter, ExciterSettings, JointSample, Limits, chirp_reference
from flex_ident.excitation.exciter import Output

RATE_HZ = 500.0
CHIRP = ChirpSettings(0.5, 20.0, 4.0, 0.1, profile="constant_velocity", fade_s=0.5)
LIMITS = Limits(-0.5, 0.5, 1.0, 50.0, 0.2)


class Servo:
    """A joint that lags its position command by 10 ms, or integrates a velocity command."""

    def __init__(self, exciter: Exciter, position: float = 0.0) -> None:
        self.exciter, self.position, self.velocity, self.effort, self.now = exciter, position, 0.0, 1.0, 100.0
        self.outputs: list[Output] = []
        self.sample = lambda s: s

    def tick(self, step: float = 1.0 / RATE_HZ) -> Output:
        self.now += step
        self.exciter.observe(
            self.sample(JointSample(self.now, self.now, self.position, self.velocity, self.effort, (0.7,)))
        )
        output = self.exciter.step(self.now)
        before = self.position
        if output.command is not None:
            if self.exciter.settings.interface == "position":
                self.position += (output.command - self.position) * min(1.0, step / 0.01)
            elif self.exciter.settings.interface == "velocity":
                self.position += output.command * step
        self.velocity = (self.position - before) / step
        self.outputs.append(output)
        return output

    def run(self, seconds: float) -> Output:
        output = self.tick()
        for _ in range(round(seconds * RATE_HZ)):
            output = self.tick()
        return output


def servo(limits: Limits = LIMITS, chirp: ChirpSettings = CHIRP, position: float = 0.0, **settings: object) -> Servo:
    exciter = Exciter(
        ExciterSettings("elbow", rate_hz=RATE_HZ, **settings), chirp_reference(chirp), limits  # type: ignore[arg-type]
    )  # fmt: skip
    made = Servo(exciter, position)
    made.tick()
    return made


def started(**kwargs: object) -> Servo:
    made = servo(**kwargs)  # type: ignore[arg-type]
    assert made.exciter.start(made.now) == ""
    return made


def commands_stay_inside(made: Servo, limits: Limits = LIMITS) -> None:
    """No command, and no step between two commands, may leave the limits."""
    given = [o.command for o in made.outputs if o.command is not None]
    if made.exciter.settings.interface == "position":
        assert all(limits.position_min <= c <= limits.position_max for c in given)
        steps = [abs(b - a) * RATE_HZ for a, b in itertools.pairwise(given)]
        assert max(steps, default=0.0) <= limits.velocity * 1.001
    elif made.exciter.settings.interface == "velocity":
        assert all(abs(c) <= limits.velocity for c in given)
    else:
        assert all(abs(c) <= limits.effort for c in given)


@pytest.mark.parametrize("interface", ["position", "velocity"])
def test_a_whole_run(interface: str) -> None:
    made = started(interface=interface, start_position=0.2)
    output = made.run(8.0)
    assert output.state == "done"
    states = list(dict.fromkeys(o.state for o in made.outputs))
    assert states == ["idle", "moving_to_start", "exciting", "ramping_down", "done"]
    assert made.position == pytest.approx(0.2, abs=0.03)
    assert output.others == (0.7,)
    commands_stay_inside(made)


def test_effort_commands_hold_what_held_before() -> None:
    made = started(interface="effort", position_gain=20.0)
    for _ in range(2000):
        made.tick()
    commands_stay_inside(made)
    made.exciter.stop(made.now, "enough")
    made.run(1.5)
    assert made.outputs[-1].command == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("kwargs", "text"),
    [
        ({"position": 0.45}, "reduce chirp.amplitude"),
        ({"position": 0.8}, "move it inside"),
        ({"start_position": 0.6}, "allowed are -0.5 to 0.5"),
        ({"limits": replace(LIMITS, velocity=0.1)}, "allowed are 0.1 rad/s"),
        ({"chirp": replace(CHIRP, end_frequency_hz=80.0)}, "commands at 500 Hz carry up to 50 Hz"),
        ({"inertia": 100.0}, "allowed are 50 N m"),
    ],
)
def test_refusals_say_the_number_and_the_fix(kwargs: dict[str, object], text: str) -> None:
    made = servo(**kwargs)  # type: ignore[arg-type]
    assert text in made.exciter.start(made.now)
    made.run(0.2)
    assert all(o.command is None for o in made.outputs)


def test_refuses_without_fresh_states_of_the_joint() -> None:
    exciter = Exciter(ExciterSettings("elbow"), chirp_reference(CHIRP), LIMITS)
    assert "no joint states" in exciter.start(0.0)
    exciter.observe(JointSample(0.0, 0.0, None))
    assert "not in the joint states" in exciter.start(0.0)
    exciter.observe(JointSample(0.0, 0.0, math.nan))
    assert "nan" in exciter.start(0.0)
    exciter.observe(JointSample(0.1, 0.1, 0.0))
    assert "old" in exciter.start(3.0)
    exciter.observe(JointSample(3.0, 3.0, 0.0, velocity=0.5))
    assert "let it come to rest" in exciter.start(3.0)


FAULTS = {
    "nan": (lambda s: replace(s, position=math.nan), "nan"),
    "lost": (lambda s: replace(s, position=None), "vanished"),
    "stale": (lambda s: replace(s, received=s.received - 1.0, stamp=s.stamp - 1.0), "no joint state"),
    "time_jump": (lambda s: replace(s, stamp=s.stamp + 5.0), "jumps"),
    "time_back": (lambda s: replace(s, stamp=s.stamp - 5.0), "jumps"),
    "frozen": (lambda s: replace(s, position=0.3), "tracking error"),
    "outside": (lambda s: replace(s, position=0.51), "has left"),
    "fast": (lambda s: replace(s, velocity=1.5), "speed"),
    "strong": (lambda s: replace(s, effort=80.0), "effort"),
}


@pytest.mark.parametrize("interface", ["position", "velocity", "effort"])
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("after_s", [0.5, 1.6, 3.0])
def test_a_fault_ramps_down_and_says_why(fault: str, interface: str, after_s: float) -> None:
    made = started(interface=interface, position_gain=5.0)
    made.run(after_s)
    made.sample, text = FAULTS[fault]
    made.run(1.5)
    assert made.exciter.state == "aborted"
    assert text in made.exciter.reason
    commands_stay_inside(made)
    last = made.outputs[-200:]
    assert len({o.command for o in last}) == 1  # held, not moving


def test_a_late_tick_skips_and_never_stretches() -> None:
    made = started()
    made.run(1.5)
    assert made.exciter.state == "exciting"
    begin = made.now
    progress = made.outputs[-1].progress
    made.tick(0.05)
    made.tick()
    assert made.outputs[-1].progress == pytest.approx(progress + (made.now - begin) / 4.0, abs=1e-3)


def test_stop_ramps_down_smoothly_and_only_while_moving() -> None:
    made = started()
    made.run(1.8)
    speed = abs(made.outputs[-1].velocity)
    assert made.exciter.stop(made.now, "stopped by ~/stop") == ""
    made.run(1.0)
    assert made.exciter.state == "aborted"
    assert made.exciter.reason == "stopped by ~/stop"
    after = [abs(o.velocity) for o in made.outputs if o.state in ("ramping_down", "aborted")]
    assert max(after) <= speed + 1e-9
    assert "nothing to stop" in made.exciter.stop(made.now, "again")


def test_two_starts_and_a_stop_before_a_start() -> None:
    made = servo()
    assert "nothing to stop" in made.exciter.stop(made.now, "x")
    assert made.exciter.start(made.now) == ""
    made.run(0.2)
    assert "already moving to start" in made.exciter.start(made.now)


def test_a_start_position_that_cannot_be_reached_aborts() -> None:
    made = started(start_position=0.3)
    made.sample = lambda s: replace(s, position=min(s.position, 0.2), velocity=0.0)
    made.run(6.0)
    assert made.exciter.state == "aborted"
    assert "was not reached" in made.exciter.reason
    commands_stay_inside(made)


@pytest.mark.parametrize("interface", ["position", "velocity"])
def test_braking_near_a_bound_stays_inside(interface: str) -> None:
    limits = Limits(-0.11, 0.11, 1.0, 50.0, 0.2)
    for k in range(40):
        made = started(limits=limits, interface=interface)
        made.run(1.4 + 0.02 * k)
        made.exciter.stop(made.now, "x")
        made.run(0.5)
        commands_stay_inside(made, limits)
