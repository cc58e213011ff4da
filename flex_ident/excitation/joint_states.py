"""The stream of joint states as the exciter trusts it: fresh, finite, advancing, alive; and what is wrong when not."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flex_ident.excitation.clock_pace import ClockPace

FROZEN_S = 0.25
"""Time after which readings that never change are called frozen, when the reference moved meanwhile."""
FROZEN_EXCITING_S = 1.0
"""The same for any motion, however small, where velocity or effort are read too: those always change."""
DRIFT_S = 0.2
"""Time over which a speed is taken from positions."""
MOVED = 1e-3
"""Way of the reference, rad, on which living readings change."""
MOVED_POSITION_ALONE = 5e-3
"""The same where the robot gives the position alone: friction and backlash may hold that for a while."""
CLOCK_DRIFT = 2e-4
"""How fast the clocks of robot and computer may part."""
SMOOTHING = 0.02
"""Weight of the latest in the mean period of the joint states."""
REPEATED = "with the same stamp again and again: the driver repeats itself"
LIVING = "though their stamps go on: the controller is not active or refuses the commands, or the driver is stuck"
SUSPECT_S = 0.06
"""Time after which readings that never change, or do not come, are no feedback any more, long before it is a fault."""
PERIODS = 3.0
"""The same for readings that do not come, in their own periods before the motion, where that is more."""
SELDOM_S, THINNED_S = 0.02, 0.15
"""Readings have thinned out when two and more in a row, for the second time together, come each later after the one
before than the first, and than `PERIODS` of their own periods: after a mere pause they come one upon the other. So
long without one an effort is closed over the latest."""
IN_TIME_S, PERIODS_IN_TIME = 0.005, 2.0
"""How old a joint state that came in time may be when it is acted on: s, and periods of theirs where that is more."""
LEAST_SAMPLES = 2.5
"""Joint states that a period of the highest frequency needs."""
OTHER_CLOCK_S = 10.0
"""Age from which stamps are not of the same clock at all."""
IMPOSSIBLE, UNEVEN_S, JITTER = 3.0, 0.01, 5e-3
"""A position jumps when it moves by the first times the speed limit allows, the readings' unevenness, s, and a rounding
of encoders, rad, granted."""


@dataclass(frozen=True)
class JointSample:
    """One joint state as received at `received` s of the steady clock; `stamp` s of the robot's; NaN where missing.

    `others` and `others_velocity` are of the joints that hold, in the order of the commands. `position` None: the
    message does not hold the joint, but those of `names`.
    """

    received: float
    stamp: float
    position: float | None
    velocity: float = math.nan
    effort: float = math.nan
    others: tuple[float, ...] = ()
    others_velocity: tuple[float, ...] = ()
    others_effort: tuple[float, ...] = ()
    names: tuple[str, ...] = ()
    age: float = math.nan
    """How old it was when it came, s, by the clocks of robot and computer."""


class JointStateWatch:
    """The latest joint state, and the faults of the stream it came in.

    Other publishers may send messages without the joint (a gripper's): those count only when its own stop coming.
    """

    def __init__(
        self, joint: str, timeout_s: float, velocity_limit: float = math.inf, silence_s: float = SUSPECT_S
    ) -> None:
        """`silence_s`: time without a joint state after which the latest is no feedback any more."""
        self.joint = joint
        self.timeout_s = timeout_s
        self._silence_s = silence_s
        self._velocity_limit = velocity_limit
        self.publishers: tuple[str, ...] = ()
        """Names of those who publish joint states."""
        self._sample: JointSample | None = None
        self._without: JointSample | None = None
        self._jump = ""
        self._period = self._usual = 0.0
        self._gaps: list[float] = []
        self._pace = ClockPace()
        self._pace_seen = True
        """Whether it was known when the motion began: else it is looked at once it is, on the way to the start."""
        self._delay = math.inf
        self._distrusted = False
        self._repeated = False
        self._changed_at = math.inf
        self._lowest, self._highest = math.inf, -math.inf
        self._had_velocity = self._had_effort = False
        self._past: list[JointSample] = []

    def observe(self, sample: JointSample) -> None:
        """Take a joint state."""
        if sample.position is None:
            self._without = sample
            return
        before = self._sample
        self._sample = sample
        if not self._past or sample.received - self._past[-1].received > 0.5 * DRIFT_S:
            self._past = [*self._past[-1:], sample]
        if before is None or before.position is None:
            self._changed_at = sample.received
            return
        self._take_pace(sample, before)
        passed = sample.stamp - before.stamp
        self._repeated = passed == 0.0
        if 0.0 <= passed <= OTHER_CLOCK_S:
            self._period += SMOOTHING * (passed - self._period) if self._period else passed
        drifted = self._delay + CLOCK_DRIFT * max(0.0, sample.received - before.received)
        self._delay = min(drifted, sample.received - sample.stamp)
        jump = self._time_jump(sample, before) or self._position_jump(sample, before)
        if jump and len(self.publishers) > 1:
            jump += f": {' and '.join(self.publishers)} publish joint states, do two of them know the joint?"
        self._jump = self._jump or jump
        pairs = ((sample.position, before.position), (sample.velocity, before.velocity), (sample.effort, before.effort))
        if not all(_same(a, b) for a, b in pairs):
            self._changed_at = sample.received
            self._lowest, self._highest = math.inf, -math.inf

    def _take_pace(self, sample: JointSample, before: JointSample) -> None:
        """How often they come, and how fast their time passes."""
        gap = sample.received - before.received
        later = gap > max(SELDOM_S, PERIODS * (self._usual or self._period))
        self._gaps = [*self._gaps, gap] if later else []
        if self._time_jump(sample, before):
            self._pace.restart()
        self._pace.observe(sample.received, sample.stamp)

    def _time_jump(self, sample: JointSample, before: JointSample) -> str:
        passed = sample.stamp - before.stamp
        if 0.0 <= passed <= sample.received - before.received + self.timeout_s:
            return ""
        return f"the joint states' time jumps by {passed:+.3f} s"

    def _position_jump(self, sample: JointSample, before: JointSample) -> str:
        """Whether a joint has moved as none can from one joint state to the next."""
        passed = max(sample.stamp - before.stamp, sample.received - before.received, 0.0)
        most = IMPOSSIBLE * self._velocity_limit * (passed + UNEVEN_S) + JITTER
        whose = f"'{self.joint}'"
        for now, then in zip((sample.position, *sample.others), (before.position, *before.others), strict=False):
            way = math.nan if now is None or then is None else now - then
            if math.isfinite(way) and abs(way) > most:
                wraps = abs(abs(way) - math.tau) <= most
                turn = ", a whole turn: it wraps, and robot_description does not say that it is continuous"
                return (
                    f"the position of {whose} jumps by {way:+.3g} rad in {1e3 * passed:.0f} ms, where "
                    f"{self._velocity_limit:.3g} rad/s are allowed{turn if wraps else ''}"
                )
            whose = "a joint that shall hold"
        return ""

    def recordable(self, highest_hz: float) -> str:
        """Why what comes cannot be identified from, for a motion up to that frequency; empty when it can."""
        sample = self._sample
        if sample is None:
            return ""
        if math.isnan(sample.effort):
            return (
                f"the joint states hold no effort of '{self.joint}', without which nothing is identified: have the "
                "driver publish it, or set recording.require_effort false where another recorded topic holds it."
            )
        rate_hz = 1.0 / self._period if self._period > 0.0 else math.inf
        if rate_hz < LEAST_SAMPLES * highest_hz:
            needed_hz, most_hz = LEAST_SAMPLES * highest_hz, rate_hz / LEAST_SAMPLES
            return (
                f"the joint states come at {rate_hz:.0f} Hz, a chirp up to {highest_hz:g} Hz needs {needed_hz:.0f} Hz: "
                f"reduce chirp.end_frequency_hz to {most_hz:.3g}, or have the driver publish faster."
            )
        return ""

    @property
    def period_s(self) -> float:
        """Mean time between two joint states of late, s; 0: not known."""
        return self._period

    def latency_s(self) -> float:
        """How old joint states are when they come soonest, s, by the clocks of robot and computer; NaN: no telling."""
        sample = self._sample
        if sample is None or not abs(sample.age) < OTHER_CLOCK_S:
            return math.nan
        return sample.age - self._behind(sample)

    def thinned(self) -> str:
        """That they come much more seldom than before the motion; empty when they do not."""
        if len(self._gaps) < 2 or sum(self._gaps) < THINNED_S:
            return ""
        period, before = sum(self._gaps) / len(self._gaps), f" before {1.0 / self._usual:.0f} Hz" if self._usual else ""
        return f"the joint states have thinned out: {len(self._gaps)} in a row came at {1.0 / period:.0f} Hz,{before}"

    def distrust(self) -> None:
        """Believe nothing of it until the next motion begins."""
        self._distrusted = True

    @property
    def distrusted(self) -> bool:
        """Whether nothing of it is believed until the next motion begins."""
        return self._distrusted

    def begin(self, now: float) -> None:
        """Forget what happened before a motion; remember which readings the robot gives."""
        sample = self._sample
        self._jump = ""
        self._distrusted = self._repeated = False
        self._usual, self._gaps = self._period, []
        self._pace_seen = self._pace.known
        self._changed_at = now
        self._lowest, self._highest = math.inf, -math.inf
        self._had_velocity = sample is not None and math.isfinite(sample.velocity)
        self._had_effort = sample is not None and math.isfinite(sample.effort)

    def speeds(self) -> tuple[float, ...]:
        """Speeds, rad/s, of the joint and of those that hold: as given, else by how far they have moved of late."""
        sample = self._sample
        if sample is None or sample.position is None:
            return ()
        given = (sample.velocity, *(sample.others_velocity or (math.nan,) * len(sample.others)))
        past = self._past[0]
        passed = sample.received - past.received
        if passed < 0.25 * DRIFT_S or past.position is None:
            return tuple(0.0 if math.isnan(v) else v for v in given)
        pairs = zip((sample.position, *sample.others), (past.position, *past.others), strict=True)
        moved = tuple((now - then) / passed for now, then in pairs)
        return tuple(d if math.isnan(v) else v for v, d in zip(given, moved, strict=True))

    def trusted(self, now: float) -> JointSample | None:
        """The latest joint state when it is fresh and finite."""
        sample = self._sample
        if sample is None or sample.position is None or not math.isfinite(sample.position):
            return None
        return sample if now - sample.received <= self.timeout_s and not self._distrusted else None

    def feedback(self, now: float) -> JointSample | None:
        """The latest joint state when it may be acted on: trusted, just come, not the same for suspiciously long."""
        sample = self.trusted(now)
        periods_s = PERIODS * (self._usual or self._period)
        suspect_s = max(SUSPECT_S, periods_s)
        if sample is None or self._jump or now - sample.received + self._behind(sample) > suspect_s:
            return None
        if now - sample.received > max(self._silence_s, periods_s):
            return None
        alive = now - self._changed_at <= suspect_s
        return sample if alive or not self._moved_meanwhile() else None

    def late_s(self, now: float) -> float:
        """By how much older the latest joint state is than one that came in time can be, s; 0: it came in time."""
        sample = self._sample
        if sample is None:
            return 0.0
        in_time = max(IN_TIME_S, PERIODS_IN_TIME * (self._usual or self._period))
        return max(0.0, now - sample.received + self._behind(sample) - in_time)

    def _behind(self, sample: JointSample) -> float:
        """By how much later a sample came than others do, s; whatever the clocks of robot and computer say."""
        return max(0.0, sample.received - sample.stamp - self._delay) if math.isfinite(self._delay) else 0.0

    def _moved_meanwhile(self) -> bool:
        """Whether the reference has moved, since the readings changed last, as far as living ones do not stay."""
        more = self._had_velocity or self._had_effort
        return self._highest - self._lowest > (MOVED if more else MOVED_POSITION_ALONE)

    def absence(self, now: float) -> str:
        """Why there is no fresh and finite joint state to begin with; empty when there is one."""
        sample, without = self._sample, self._without
        if sample is None or sample.position is None:
            if without is not None:
                return f"joint '{self.joint}' is not in the joint states, which hold {_listed(without.names)}."
            return "no joint states arrive: check the topic and that the robot's driver runs."
        age = now - sample.received
        if age > self.timeout_s:
            if without is not None and now - without.received <= self.timeout_s:
                return f"joint '{self.joint}' has vanished from the joint states, which hold {_listed(without.names)}."
            return f"the latest joint state is {age:.2f} s old, {self.timeout_s:.2f} s allowed: is the driver running?"
        if not math.isfinite(sample.position):
            return f"the position of '{self.joint}' is {sample.position}: the driver publishes no number."
        if why := self._pace.problem():
            return why
        if self.timeout_s < sample.age < OTHER_CLOCK_S:
            return (
                f"the joint states are {sample.age:.2f} s old when they come, {self.timeout_s:.2f} s allowed: is the "
                "network slow, or do the clocks of robot and computer differ?"
            )
        return ""

    def fault(self, now: float, reference: float, *, exciting: bool) -> str:
        """What is wrong with the stream while the joint follows `reference`, rad; empty when nothing is."""
        sample, without = self._sample, self._without
        if sample is None or sample.position is None:
            return "no joint states arrive"
        age = now - sample.received
        if age > self.timeout_s:
            if without is not None and without.received > sample.received:
                return f"joint '{self.joint}' has vanished from the joint states for {age:.3f} s"
            return f"no joint state for {age:.3f} s, {self.timeout_s:.3f} s allowed"
        if self._jump:
            return self._jump
        if not self._pace_seen and self._pace.known:
            self._pace_seen = True
            if why := self._pace.problem():
                return why
        behind = self._behind(sample)
        if behind > self.timeout_s and self._repeated:
            return f"the joint states are frozen: the same for {behind:.2f} s, {REPEATED}"
        if behind > self.timeout_s:
            return f"the joint states are {behind:.3f} s behind, {self.timeout_s:.3f} s allowed: they wait somewhere"
        for what, value, had in (
            ("position", sample.position, True),
            ("velocity", sample.velocity, self._had_velocity),
            ("effort", sample.effort, self._had_effort),
        ):
            if math.isinf(value) or (had and math.isnan(value)):
                return f"the {what} of '{self.joint}' is {value}"
        return self._frozen(now, reference, exciting)

    def _frozen(self, now: float, reference: float, exciting: bool) -> str:
        self._lowest, self._highest = min(self._lowest, reference), max(self._highest, reference)
        still, way = now - self._changed_at, self._highest - self._lowest
        more = self._had_velocity or self._had_effort
        by_motion = still > max(FROZEN_S, 2.0 * self.timeout_s) and self._moved_meanwhile()
        if by_motion or (exciting and more and still > FROZEN_EXCITING_S):
            lasting = f"the same for {still:.2f} s while the reference moved {way:.2g} rad"
            return f"the joint states are frozen: {lasting}, {REPEATED if self._repeated else LIVING}"
        return ""


def _same(a: float, b: float) -> bool:
    return a == b or (math.isnan(a) and math.isnan(b))


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(names[:8]) + (", ..." if len(names) > 8 else "") if names else "none"
