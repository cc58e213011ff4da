"""The exciter's rules: what must hold before a joint moves, what it is commanded, and what makes it stop.

Stepped sample by sample with a steady clock's time; ROS, threads and files are the node's business. Whatever comes in,
the commanded position and speed stay inside the limits.
"""

from __future__ import annotations

import math

from flex_ident.errors import ConfigurationError
from flex_ident.excitation.chirp import Reference
from flex_ident.excitation.command_stream import RELEASE_S, CommandStream
from flex_ident.excitation.commands import CommandLaw
from flex_ident.excitation.following import FirstMotion, Following
from flex_ident.excitation.holding import Hold
from flex_ident.excitation.joint_states import SELDOM_S, SUSPECT_S, JointSample, JointStateWatch
from flex_ident.excitation.limits import Limits
from flex_ident.excitation.motions import Braking, Travel, braking, travel, with_first_motion
from flex_ident.excitation.objections import STILL, start_objection
from flex_ident.excitation.output import MOVING, Output, State
from flex_ident.excitation.settings import ExciterSettings
from flex_ident.excitation.turns import Turns

SETTLING_S = 2.0
"""Time after the way to the start pose in which the joint must arrive."""
EFFORT_MARGIN = 1.05
"""A drive that works at its limit reads a little more than that, for noise; more is a fault."""
LATE_TICKS = 2.0
"""However late a tick comes, the reference moves on by no more than the speed allows in this many periods."""
BUSY = "is the machine too busy?"
MUCH = 0.3
"""Share of the efforts that late joint states take, from which on a joint that does not follow is not to blame."""
CATCHING_UP, OF_ITS_OWN, AT_MOST = 0.5, 1.1, 0.99
"""The speed of catching up: with the chirp the first share of the limit, or the second of the chirp's own highest speed
if that is more, and at most the third of the limit: the joint overshoots, and a drive's clock need not agree with ours.
On the way to a position, which nobody measures, the second of that way's highest speed."""
YIELD = 2.0
"""The reference yields to a joint that is held off it by up to this many tracking errors."""


class Exciter:
    """The state machine. `step(now)` is called at each tick, everything else whenever it happens; not thread-safe."""

    def __init__(self, settings: ExciterSettings, reference: Reference, limits: Limits) -> None:
        self.state: State = "idle"
        self.reason = ""
        self.settings, self.reference, self.limits = settings, reference, limits
        silence_s = SELDOM_S if settings.interface == "effort" else SUSPECT_S
        self._watch = JointStateWatch(settings.joint, settings.state_timeout_s, limits.velocity, silence_s)
        self._turns = Turns(settings.continuous)
        self._last, self._last_at = (0.0, 0.0), 0.0
        self._began = 0.0
        self._progress = 0.0
        self._yielding = False
        self._yield_travel: Travel | None = None
        self._first, self._following = FirstMotion(), Following(0.0)
        self._after: State = "done"
        self._hold: Hold | None = None
        self._left = self._unseen = False
        self.largest_error = 0.0
        """The largest tracking error of the run, rad."""

    @property
    def _approach_speed(self) -> float:
        return min(self.settings.approach_velocity, 0.5 * self.limits.velocity)

    def observe(self, sample: JointSample) -> None:
        """Take a joint state."""
        if self.state not in MOVING:
            self._turns.restart()
        self._watch.observe(self._turns.unwrapped(sample))

    def published_by(self, names: tuple[str, ...]) -> None:
        """Take the names of those who publish joint states."""
        self._watch.publishers = names

    def recordable(self) -> str:
        """Why what comes from the robot cannot be identified from; empty when it can."""
        return self._watch.recordable(self.reference.highest_hz)

    # -- before it moves

    def objection(self, now: float) -> str:
        """Why the joint must not move now: the number and the fix in one line; empty when it may."""
        if self.state in MOVING:
            return f"already {self.state.replace('_', ' ')}: call ~/stop first."
        return start_objection(self.settings, self.limits, self.reference, self._watch, now)

    def start(self, now: float) -> str:
        """Begin to move to the start pose; the objection when that must not be, else empty."""
        why = self.objection(now)
        sample = self._watch.trusted(now)
        if why or sample is None or sample.position is None:
            return why
        s = self.settings
        try:
            law = CommandLaw(
                s.interface, s.gains, self.limits, sample, carry=s.carry_effort, others_effort=s.held_effort
            )
        except ConfigurationError as error:
            return str(error)
        self._center = sample.position if s.start_position is None else s.start_position
        self._travel, self._first = travel(now, sample.position, self._center, self._approach_speed), FirstMotion()
        if s.interface != "effort":  # whose gains may be too weak for a small motion against friction
            self._travel = with_first_motion(self._travel, self._approach_speed, self.reference.bounds, self.limits)
        self._last, self._last_at = (sample.position, 0.0), now
        self._stream = CommandStream(law, now, sample.position, sample)
        self._hold = None
        if s.interface == "effort":
            self._hold = Hold(
                s.joint, s.held, s.gains, self.limits, sample, s.carry_effort, s.held_effort, s.continuous,
                s.state_timeout_s,
            )  # fmt: skip
        self._left = self._unseen = False
        self._progress, self._yield_travel, self.largest_error = 0.0, None, 0.0
        self._watch.begin(now)
        self.state, self.reason = "moving_to_start", ""
        return ""

    # -- while it moves

    def stop(self, why: str) -> str:
        """Ramp the joint down, for the reason given; the objection when nothing moves, else empty."""
        if self.state not in MOVING:
            return f"nothing to stop: {self.state}."
        if self.state != "ramping_down":
            self._ramp_down(why, "aborted")
        return ""

    def step(self, now: float) -> Output:
        """What to command at this tick."""
        if self.state not in MOVING:
            return self._output(now)
        gap = now - self._last_at
        if gap > self._stream.lease_s:
            self._stood_still(gap)
            return self._output(now)
        self._see_again(now)
        if self.state != "ramping_down":
            self._check(now, gap)
        elif self._unbelievable(now):
            self._watch.distrust()
        position, velocity = self._motion(now)
        inside, limit = self.limits.held(position), self.limits.velocity
        if inside != position or abs(velocity) > limit:
            if self.state != "ramping_down":
                self._ramp_down(f"the reference leaves its bounds at {position:.4g} rad", "aborted")
            position, velocity = inside, min(max(velocity, -limit), limit)
        self._last, self._last_at = self._reachable(now, position, velocity), now
        return self._output(now)

    def _reachable(self, now: float, position: float, velocity: float) -> tuple[float, float]:
        """The reference, or after a tick that came late the nearest to it that the speed of catching up allows.

        A drive sees the commands alone: what was missed meanwhile is caught up with in steps, not in one.
        """
        last, speed = self._last[0], self._speed_of_catching_up()
        reach = speed * min(now - self._last_at, LATE_TICKS / self.settings.rate_hz)
        if abs(position - last) <= reach:
            return position, velocity
        ahead = math.copysign(1.0, position - last)
        return last + ahead * reach, ahead * speed

    def _see_again(self, now: float) -> None:
        """Under efforts, go on from where the joint is when it is seen again: nothing has held it meanwhile.

        An effort that would bring it back to a reference that went on without it knows no limit of the speed.
        """
        if self.settings.interface != "effort":
            return
        sample = self._watch.feedback(now)
        if sample is not None and sample.position is not None and self._unseen:
            self._last = (self.limits.held(sample.position), self._last[1])
        self._unseen = sample is None

    def _speed_of_catching_up(self) -> float:
        limit = self.limits.velocity
        if self.state == "moving_to_start" or self._yield_travel is not None:
            return OF_ITS_OWN * self._approach_speed
        return min(AT_MOST * limit, max(CATCHING_UP * limit, OF_ITS_OWN * self.reference.bounds.speed))

    def _stood_still(self, gap: float) -> None:
        """End at once, as what was commanded last has stood for too long: whoever guards the joint has stopped it."""
        self._watch.distrust()
        self._last = (self._last[0], 0.0)
        self.state = "aborted"
        self._left = self._hold is not None
        self.reason = f"this node stood still for {gap:.2f} s, and with it the commands: {BUSY}"

    def _check(self, now: float, gap: float) -> None:
        """Ramp down when anything about the robot is wrong; blind when that is what it says of itself."""
        position = self._last[0]
        if why := self._unbelievable(now):
            if gap > 0.5 * self.settings.state_timeout_s and self._watch.trusted(now) is None:
                why = f"this node stood still for {gap:.2f} s, and saw no joint state meanwhile"
            self._watch.distrust()
            self._ramp_down(why, "aborted")
            return
        sample, limits = self._watch.trusted(now), self.limits
        if sample is None or sample.position is None:
            return
        error = abs(sample.position - position)
        self.largest_error = max(self.largest_error, error)
        if not limits.position_min <= sample.position <= limits.position_max:
            bounds = f"{limits.position_min:.4g} to {limits.position_max:.4g} rad"
            self._ramp_down(f"the position, {sample.position:.4g} rad, has left {bounds}", "aborted")
        elif abs(sample.velocity) > limits.velocity:
            speed = abs(sample.velocity)
            self._ramp_down(f"the speed, {speed:.3g} rad/s, exceeds {limits.velocity:.3g} rad/s", "aborted")
        elif abs(sample.effort) > EFFORT_MARGIN * limits.effort:
            effort = abs(sample.effort)
            self._ramp_down(f"the effort, {effort:.3g} N m, exceeds {limits.effort:.3g} N m", "aborted", yielding=True)
        elif error > limits.tracking_error:
            why = f"the tracking error, {error:.3g} rad, exceeds {limits.tracking_error:.3g} rad"
            self._ramp_down(why, "aborted", yielding=True)
        elif moved := self._moved_away(sample):
            self._ramp_down(moved, "aborted")
        elif self._watch.feedback(now) is not None:
            if self.state == "moving_to_start":
                self._first.add(*self._last, sample.position)
            elif why := self._following.fault(now, *self._last, sample.position):
                self._ramp_down(self._why_not_following(why), "aborted")

    def _why_not_following(self, why: str) -> str:
        """Why the joint does not follow: weak efforts, or late readings that hold them back, let it stand as well."""
        if self.settings.interface != "effort":
            return why
        share = self._stream.held_back
        if share > MUCH:
            return f"the joint states were too far behind, which took {100 * share:.0f} % of the efforts: {BUSY}"
        return f"{why} Or are the gains too weak for its friction?"

    def _unbelievable(self, now: float) -> str:
        """Why the joint states are not to be acted on any more; empty when they are."""
        why = self._watch.fault(now, self._last[0], exciting=self.state == "exciting")
        if why or self.settings.interface != "effort":
            return why
        why = self._watch.thinned()
        return f"{why}: too few to hold a joint by effort" if why else ""

    def _moved_away(self, sample: JointSample) -> str:
        """Which joint that shall hold does not; empty when all do."""
        for name, position, held_at in zip(self.settings.held, sample.others, self._stream.law.others_at, strict=False):
            error = abs(position - held_at)
            if not math.isfinite(error):
                self._watch.distrust()
                return f"the position of '{name}', which shall hold, is {position}"
            if error > self.limits.tracking_error:
                return f"joint '{name}', which shall hold, is {error:.3g} rad away from where it was"
        return ""

    def _ramp_down(self, why: str, after: State, *, yielding: bool = False) -> None:
        """Brake from here; `yielding`: something may be in the way that must not be pushed against for long."""
        self._braking: Braking = braking(self._last_at, *self._last, self.limits)
        self._stream.brake()
        self._yielding, self._yield_travel = yielding, None
        self.state, self.reason, self._after = "ramping_down", why, after

    def _motion(self, now: float) -> tuple[float, float]:
        """Position and velocity of the reference now; moves on to the next state when its time has come."""
        if self.state == "moving_to_start":
            if now < self._travel.end:
                return self._travel.at(now)
            here = self._arrival(now)
            if here is None and self._travel.aside and (why := self._first.fault()):
                self._ramp_down(why, "aborted")
            elif here is None:
                self.state, self._began = "exciting", now
                self._watch.begin(now)
                self._following = Following(now)
            elif now > self._travel.end + SETTLING_S:
                goal = f"the start position {self._center:.4g} rad"
                why = f"{goal} was not reached: at {here:.4g} rad after {SETTLING_S:g} s"
                self._ramp_down(why, "aborted", yielding=True)
            return self._center, 0.0
        if self.state == "exciting":
            t = now - self._began
            self._progress = min(1.0, t / self.reference.total_s)
            if t < self.reference.total_s:
                deviation, velocity, _ = self.reference.at(t)
                return self._center + deviation, velocity
            self._ramp_down("", "done")
        return self._braked(now)

    def _arrival(self, now: float) -> float | None:
        """Where the joint is, rad, when that is not the start position at rest; None when it is there."""
        sample = self._watch.trusted(now)
        if sample is None or sample.position is None:
            return math.nan
        allowed = min(0.02, 0.5 * self.limits.tracking_error)
        moving = math.isfinite(sample.velocity) and abs(sample.velocity) > STILL
        return sample.position if moving or abs(sample.position - self._center) > allowed else None

    def _braked(self, now: float) -> tuple[float, float]:
        """The reference while ramping down: to a standstill, then to where the joint is if something is in the way."""
        end = self._braking.end
        motion = self._braking.at(now)
        if self._yielding and self.settings.interface == "position" and now >= end:
            if self._yield_travel is None:
                goal = self._yielded(now, motion[0])
                self._yield_travel = travel(now, motion[0], goal, self._approach_speed)
            end, motion = self._yield_travel.end, self._yield_travel.at(now)
        if self.settings.interface == "effort":
            end += RELEASE_S
        if now >= end:
            self.state = self._after
        return motion

    def _yielded(self, now: float, position: float) -> float:
        """Where the joint is, rad, when that is near enough to `position` to be believed, else `position`."""
        sample = self._watch.trusted(now)
        if sample is None or sample.position is None:
            return position
        near = abs(sample.position - position) <= YIELD * self.limits.tracking_error
        return self.limits.held(sample.position) if near else position

    # -- commands

    def _output(self, now: float) -> Output:
        position, velocity = self._last
        if self.state == "idle":
            return Output(self.state, None, (), position, velocity, self._progress, self.reason)
        stream, sample, late = self._stream, self._watch.feedback(now), self._watch.late_s(now)
        if self.state in ("moving_to_start", "exciting"):
            stream.follow(now, position, velocity, sample, late)
        elif self.state == "ramping_down":
            stream.ramp_down(now, position, velocity, self._braking, sample, late)
        else:
            stream.rest(position)
        return Output(
            self.state, stream.command, stream.others, position, velocity, self._progress, self.reason,
            stream.safe, stream.lease_s, self._hold, stream.seen, self._left,
        )  # fmt: skip
