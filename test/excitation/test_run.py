"""The phases of a run, without ROS: what begins it, what ends it, and what is said of it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from servo import CHIRP, GAINS, LIMITS, RATE_HZ

from flex_ident.excitation import Exciter, ExciterSettings, JointSample, chirp_reference
from flex_ident.excitation.run import ABORTED, BEGIN_S, PATIENCE_S, READY_S, Run
from flex_ident.excitation.surroundings import Surroundings

READY = Surroundings("/commands", "/joint_states", listeners=1, states_published=True, description="here")
STEP = 1.0 / RATE_HZ


class Played:
    """A run and a joint that follows at once, stepped through time."""

    def __init__(self, *, auto_start: bool = False, exit_when_done: bool = True) -> None:
        exciter = Exciter(ExciterSettings("elbow", rate_hz=RATE_HZ, gains=GAINS), chirp_reference(CHIRP), LIMITS)
        self.now, self.around, self.said = 100.0, READY, []
        self.run = Run(exciter, auto_start=auto_start, exit_when_done=exit_when_done, now=self.now)
        self.position = 0.0
        self.see()

    def see(self) -> bool:
        return self.run.observe(JointSample(self.now, self.now, self.position, 0.0, 1.0 + self.now % 0.1))

    def watch(self) -> None:
        self.run.watch(self.now, lambda: self.around)
        self.said += self.run.notes()

    def wait(self, seconds: float) -> None:
        """Let time pass in which nothing moves, as the node does when it can open its recording."""
        for _ in range(round(10 * seconds)):
            self.now += 0.1
            self.see()
            self.watch()
            if self.run.phase == "opening":
                self.run.opened(self.now)

    def move(self, seconds: float) -> None:
        for k in range(round(seconds * RATE_HZ)):
            self.now += STEP
            self.see()
            output = self.run.step(self.now)
            self.position = output.position
            if k % 50 == 0:
                self.watch()
            if self.run.phase != "moving":
                break

    def begin(self) -> None:
        assert self.run.request(self.now, self.around) == ""
        self.run.opened(self.now)
        self.now += STEP
        assert self.see()

    def texts(self, level: str) -> list[str]:
        self.said += self.run.notes()
        return [note.text for note in self.said if note.level == level]


def test_a_whole_run_goes_through_its_phases() -> None:
    played = Played()
    run = played.run
    assert run.phase == "idle"
    assert run.request(played.now, READY) == ""
    assert run.phase == "opening"
    assert "already starting" in run.request(played.now, READY)
    run.opened(played.now)
    assert run.phase == "pending"
    assert run.report().state == "idle"
    played.now += STEP
    assert played.see()
    assert run.phase == "moving"
    assert "call ~/stop first" in run.busy_with()
    played.move(8.0)
    assert run.phase == "closing"
    assert "being closed" in run.request(played.now, READY)
    assert not run.ending
    run.closed()
    assert (run.phase, run.ending, run.status) == ("idle", True, 0)
    assert run.report().state == "done"
    assert run.report().progress == 1.0


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"listeners": 0}, "nobody listens on /commands: is the controller active?"),
        ({"others": "joystick"}, "joystick publishes on /commands too"),
        ({"states_published": False}, "nobody publishes /joint_states"),
        ({"description": "announced"}, "announced and has not arrived yet"),
        ({"description": "absent", "description_required": True}, "limits.require_urdf is true"),
        ({"description": "absent", "open_limits": ("limits.velocity",)}, "limits.velocity not given"),
        ({"description": "volatile", "open_limits": ("limits.velocity",)}, "transient local"),
        ({"limits_problem": "joint 'elbow' is fixed"}, "is fixed"),
        ({"controller_problem": "other joints"}, "other joints"),
        ({"guard_problem": "no guard"}, "no guard"),
    ],
)
def test_what_is_missing_forbids_to_start(change: dict[str, object], text: str) -> None:
    played = Played()
    assert text in played.run.request(played.now, replace(READY, **change))
    assert played.run.phase == "idle"


def test_what_cannot_be_identified_from_is_not_recorded() -> None:
    played = Played()
    recording = replace(READY, records=True)
    for _ in range(300):  # at 25 Hz, where the chirp goes up to 20 Hz
        played.now += 0.04
        played.see()
    why = played.run.request(played.now, recording)
    assert "come at 25 Hz, a chirp up to 20 Hz needs 50 Hz: reduce chirp.end_frequency_hz to 10" in why
    for _ in range(900):
        played.now += STEP
        played.see()
    played.run.observe(JointSample(played.now, played.now, 0.0, 0.0))
    assert "hold no effort of 'elbow'" in played.run.request(played.now, recording)
    assert played.run.request(played.now, READY) == ""


def test_a_volatile_description_is_no_hindrance_where_all_limits_are_given() -> None:
    played = Played()
    assert played.run.request(played.now, replace(READY, description="volatile")) == ""


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"listeners": 0}, "nobody listens on /commands any more"),
        ({"others": "joystick"}, "joystick publishes on /commands too"),
        ({"guard_problem": "the guard has died"}, "the guard has died"),
        ({"recording_failure": "the disk is full"}, "the disk is full"),
    ],
)
def test_what_changes_around_a_motion_ends_it(change: dict[str, object], text: str) -> None:
    played = Played()
    played.begin()
    played.move(2.0)
    played.around = replace(READY, **change)
    played.move(3.0)
    assert played.run.phase == "closing"
    played.run.closed()
    assert played.texts("stderr") == [f"aborted: {text}"]
    assert played.run.status == ABORTED


def test_without_a_joint_state_nothing_begins() -> None:
    played = Played(exit_when_done=False)
    assert played.run.request(played.now, READY) == ""
    played.run.opened(played.now)
    played.now += 1.1 * BEGIN_S
    played.watch()
    assert played.run.phase == "closing"
    played.run.closed()
    assert "no joint state with 'elbow' came" in played.texts("error")[0]
    assert not played.run.ending


def test_the_joint_is_looked_at_again_once_the_recording_is_open() -> None:
    played = Played(exit_when_done=False)
    assert played.run.request(played.now, READY) == ""
    played.run.opened(played.now)
    played.position = 2.0
    played.now += STEP
    assert not played.see()
    assert played.run.phase == "closing"
    played.run.closed()
    assert "stands at 2 rad" in played.run.report().reason


def test_a_stop_before_the_motion_and_one_without() -> None:
    played = Played(exit_when_done=False)
    assert played.run.stop("stopped by ~/stop") == (False, "nothing to stop: idle.")
    assert played.run.request(played.now, READY) == ""
    played.run.opened(played.now)
    assert played.run.stop("stopped by ~/stop") == (True, "nothing had moved yet")
    played.now += STEP
    assert not played.see()
    played.run.closed()
    assert played.run.report().state == "idle"
    played.begin()
    played.move(1.5)
    assert played.run.stop("stopped by ~/stop") == (True, "ramping down")


def test_an_automatic_start_waits_for_what_is_missing_and_gives_up_in_the_end() -> None:
    played = Played(auto_start=True)
    played.around = replace(READY, listeners=0)
    played.wait(5.0)
    assert played.run.phase == "idle"
    assert len(played.texts("info")) == 1
    played.wait(READY_S)
    assert played.run.ending
    assert played.run.status == ABORTED
    assert "nobody listens" in played.texts("stderr")[0]
    played = Played(auto_start=True)
    played.around = replace(READY, listeners=0)
    played.wait(5.0)
    played.around = READY
    played.wait(0.3)
    assert played.run.phase == "moving"


def test_an_automatic_start_gives_up_sooner_when_the_robot_objects_or_nothing_can_be_recorded() -> None:
    played = Played(auto_start=True)
    played.around = replace(READY, limits_problem="joint 'elbow' is fixed")
    played.wait(PATIENCE_S + 0.5)
    assert played.run.ending
    played = Played(auto_start=True)
    for _ in range(40):
        played.now += 0.1
        played.see()
        played.watch()
        if played.run.phase == "opening":
            played.run.not_opened(played.now, "no room")
    assert played.run.ending
    assert played.texts("stderr") == ["no room"]


@pytest.mark.parametrize("auto_start", [True, False])
def test_an_interrupt_ends_whatever_there_is(auto_start: bool) -> None:
    for phase in ("idle", "pending", "moving"):
        played = Played(auto_start=auto_start, exit_when_done=False)
        if phase != "idle":
            assert played.run.request(played.now, READY) == ""
            played.run.opened(played.now)
        if phase == "moving":
            played.now += STEP
            assert played.see()
            played.move(2.0)
        for _ in range(3):  # a node looks at its signals again and again
            played.run.interrupt("stopped by SIGTERM")
        if phase == "moving":
            played.move(1.0)
            assert played.run.phase == "closing"
        if phase != "idle":
            assert not played.run.ending
            played.run.closed()
        assert played.run.ending
        failed = phase == "moving" or auto_start
        assert played.run.status == (ABORTED if failed else 0)
        assert any("stopped by SIGTERM" in text for text in played.texts("stderr")) == failed


def test_a_run_whose_recording_failed_is_not_done() -> None:
    played = Played(exit_when_done=False)
    played.begin()
    played.move(8.0)
    played.run.closed("recording failed (disk)")
    assert played.run.report()[:2] == ("aborted", "recording failed (disk)")
    assert played.texts("error") == ["aborted: recording failed (disk)"]
    played.begin()
    assert played.run.report().state == "moving_to_start"


def test_commands_that_cannot_be_sent_end_the_run() -> None:
    played = Played()
    played.begin()
    played.move(1.0)
    played.run.cannot_command("commands cannot be published (x)")
    played.run.closed()
    assert played.texts("stderr") == ["aborted: commands cannot be published (x)"]
    assert played.run.status == ABORTED
