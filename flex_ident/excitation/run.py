"""One run of the exciter after the other: asked for, its recording opened, begun, over, its recording closed.

Knows nothing of ROS, threads and files: the node opens and closes the recording and has the clock tick when the phase
says so, and hands on what it sees. Not thread-safe.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

from flex_ident.excitation.exciter import Exciter
from flex_ident.excitation.joint_states import JointSample
from flex_ident.excitation.output import MOVING, Output
from flex_ident.excitation.surroundings import Surroundings

Phase = Literal["idle", "opening", "pending", "moving", "closing"]
Level = Literal["info", "warning", "error", "stderr"]
READY_S, PATIENCE_S = 30.0, 3.0
"""Time after which an automatic start gives up: while something has yet to appear, and while the robot objects."""
BEGIN_S = 1.0
"""Time in which a joint state must come after ~/start."""
DISCOVERY_S = 2.0
"""Time that others get to be found, before what is missing is said."""
ABORTED = 3


class Note(NamedTuple):
    """A sentence for the log, or for standard error."""

    level: Level
    text: str


class Report(NamedTuple):
    """The state as the outside sees it, the reason, and the share of the chirp that has been played."""

    state: str
    reason: str
    progress: float


class Run:
    """The phases `idle`, `opening` (the recording), `pending` (a joint state), `moving` and `closing`.

    `ending`: the node shall end, with `status`.
    """

    def __init__(self, exciter: Exciter, auto_start: bool, exit_when_done: bool, now: float) -> None:
        self.exciter = exciter
        self.phase: Phase = "idle"
        self.refusal = ""
        self.ending = False
        self.status = 0
        self._auto = self._wanted = auto_start
        self._exits = exit_when_done
        self._since = now
        self._pending_since = now
        self._objected_since: float | None = None
        self._cancelled = ""
        self._interrupted = False
        self._idle_said: str | None = None
        self._output: Output | None = None
        self._failure = ""
        self._notes: list[Note] = []

    @property
    def busy(self) -> bool:
        """Whether a run begins, goes on, or has yet to be closed."""
        return self.phase != "idle"

    def busy_with(self) -> str:
        """Why settings cannot change now; empty when they can."""
        if not self.busy:
            return ""
        if self.phase == "closing":
            return "the recording of the run before is being closed: try again."
        state = self.exciter.state.replace("_", " ")
        return f"'{self.exciter.settings.joint}' is {state}: call ~/stop first."

    def take(self, exciter: Exciter) -> None:
        """Go on with other settings; while idle only."""
        assert not self.busy
        self.exciter = exciter

    def notes(self) -> list[Note]:
        """What is to be said since the last call."""
        said, self._notes = self._notes, []
        return said

    # -- the beginning

    def objection(self, now: float, around: Surroundings) -> str:
        """Why nothing may move now: the number and the fix in one line; empty when it may."""
        if self.phase == "closing":
            return "the recording of the run before is being closed: call again."
        if self.phase in ("opening", "pending"):
            return "already starting: wait for ~/state."
        if self.phase == "moving":
            return self.exciter.objection(now)
        why = around.missing() or around.limits_problem or self.exciter.objection(now)
        return why or (self.exciter.recordable() if around.records else "")

    def request(self, now: float, around: Surroundings) -> str:
        """Have the recording opened, from when the next joint state begins the motion; the objection otherwise."""
        why = self.objection(now, around)
        if not why:
            self.phase, self.refusal = "opening", ""
        return why

    def opened(self, now: float) -> None:
        """The recording is open, or none is wanted."""
        self.phase, self._pending_since, self._wanted = "pending", now, False

    def not_opened(self, now: float, why: str) -> None:
        """The recording cannot be opened."""
        self.phase = "idle"
        if self._wanted:
            self._wait_or_give_up(now, why, unready=False)

    def observe(self, sample: JointSample, limits_problem: str = "") -> bool:
        """Take a joint state; True when it begins the motion and commands must be sent from now on.

        Opening the recording took a while, so all is checked again on this fresh joint state.
        """
        self.exciter.observe(sample)
        if self.phase != "pending" or sample.position is None:
            return False
        why = limits_problem or self.exciter.start(sample.received)
        if why:
            self._cancel(why)
            return False
        self._output, self._failure = None, ""
        self.phase = "moving"
        return True

    def _cancel(self, why: str) -> None:
        """Nothing has moved and nothing shall."""
        self.phase, self._cancelled = "closing", why

    def _give_up(self, why: str) -> None:
        self.refusal = why
        if self._exits and self._auto:
            self._notes.append(Note("stderr", why))
            self.status, self.ending = ABORTED, True
        else:
            self._notes.append(Note("error", f"refused: {why}"))

    # -- the motion

    def step(self, now: float) -> Output:
        """What to command at this tick; after the last one the phase is `closing`."""
        output = self.exciter.step(now)
        self._output = output
        if self.phase == "moving" and output.state not in MOVING:
            self.phase = "closing"
        return output

    def cannot_command(self, why: str) -> None:
        """The ticks have ended by an error."""
        self._failure = why
        self.phase = "closing"

    def stop(self, why: str) -> tuple[bool, str]:
        """Ramp down, or do not begin; whether there was anything to stop, and a sentence."""
        if self.phase in ("opening", "pending"):
            self._cancel(f"{why} before it moved")
            return True, "nothing had moved yet"
        objection = self.exciter.stop(why)
        return not objection, objection or "ramping down"

    def interrupt(self, why: str) -> None:
        """Ramp down if anything moves, then end."""
        self._exits = self._interrupted = True
        if self.phase == "moving":
            self.exciter.stop(why)
            return
        if self.phase in ("opening", "pending"):
            self._cancel(f"{why} before it moved")
        if self._wanted:
            self._wanted = False
            if self.phase == "idle":
                self._give_up(f"{why} before it moved")
        if self.phase == "idle":
            self.ending = True

    # -- ten times a second

    def watch(self, now: float, look: Callable[[], Surroundings]) -> None:
        """Look around: start when asked to from the beginning, stop when something is wrong, say what is missing."""
        if self.phase == "moving":
            around = look()
            self.exciter.published_by(around.states_publishers)
            if why := around.disturbance():
                self.exciter.stop(why)
        elif self.phase == "pending":
            if now - self._pending_since > BEGIN_S:
                joint = self.exciter.settings.joint
                self._cancel(f"no joint state with '{joint}' came for {BEGIN_S:g} s after ~/start.")
        elif self.phase == "idle" and self._wanted:
            self._start_when_ready(now, look())
        elif self.phase == "idle" and now - self._since > DISCOVERY_S and self.exciter.state == "idle":
            around = look()
            self._say_idle(around.missing() or around.limits_problem)

    def _say_idle(self, missing: str) -> None:
        """Say what a call needs, again when that changes."""
        if missing != self._idle_said:
            self._idle_said = missing
            rest = f"still missing: {missing}" if missing else "all that it needs is there."
            self._notes.append(Note("info", f"idle: call ~/start (std_srvs/srv/Trigger); {rest}"))

    def _start_when_ready(self, now: float, around: Surroundings) -> None:
        why = self.request(now, around)
        if why:
            self._wait_or_give_up(now, why, unready=bool(around.missing()))

    def _wait_or_give_up(self, now: float, why: str, *, unready: bool) -> None:
        if not unready and self._objected_since is None:
            self._objected_since = now
        objected = self._objected_since is not None and now - self._objected_since > PATIENCE_S
        if objected or (unready and self._exits and now - self._since > READY_S):
            self._wanted = False
            self._give_up(why)
        elif why != self.refusal:
            self.refusal = why
            self._notes.append(Note("info", f"waiting: {why}"))

    # -- the end

    def closed(self, recording_failure: str = "") -> None:
        """The recording is closed: say how it went, and end if asked to."""
        self.phase = "idle"
        if self._cancelled:
            why, self._cancelled = self._cancelled, ""
            self._give_up(why)
            self.ending = self.ending or self._interrupted
            return
        if self.exciter.state == "done":
            self._failure = self._failure or recording_failure
        report = self.report()
        if report.state == "aborted":
            self._notes.append(Note("stderr" if self._exits else "error", f"aborted: {report.reason}"))
            if self._exits:
                self.status = ABORTED
        elif self.exciter.state == "done":
            error, allowed = self.exciter.largest_error, self.exciter.limits.tracking_error
            self._notes.append(Note("info", f"largest tracking error {error:.3g} rad, allowed are {allowed:.3g} rad"))
        self.ending = self.ending or self._exits

    def report(self) -> Report:
        """The state for the outside."""
        state, reason = str(self.exciter.state), self.exciter.reason
        if self.phase in ("opening", "pending"):
            state, reason = "idle", ""
        elif self._failure:
            state, reason = "aborted", self._failure
        progress = self._output.progress if self._output is not None else 0.0
        return Report(state, reason or (self.refusal if state == "idle" else ""), progress)
