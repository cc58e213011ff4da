"""The stream of joint states as the exciter trusts it: fresh, finite, advancing, alive; and what is wrong when not."""

from __future__ import annotations

import math
from dataclasses import dataclass

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


class JointStateWatch:
    """The latest joint state, and the faults of the stream it came in.

    Other publishers may send messages without the joint (a gripper's): those count only when its own stop coming.
    """

    def __init__(self, joint: str, timeout_s: float) -> None:
        self.joint = joint
        self.timeout_s = timeout_s
        self._sample: JointSample | None = None
        self._without: JointSample | None = None
        self._jump = 0.0
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
        passed = sample.stamp - before.stamp
        if passed < 0.0 or passed > sample.received - before.received + self.timeout_s:
            self._jump = passed
        pairs = ((sample.position, before.position), (sample.velocity, before.velocity), (sample.effort, before.effort))
        if not all(_same(a, b) for a, b in pairs):
            self._changed_at = sample.received
            self._lowest, self._highest = math.inf, -math.inf

    def begin(self, now: float) -> None:
        """Forget what happened before a motion; remember which readings the robot gives."""
        sample = self._sample
        self._jump = 0.0
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
        return sample if now - sample.received <= self.timeout_s else None

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
            jump, self._jump = self._jump, 0.0
            return f"the joint states' time jumps by {jump:+.3f} s"
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
        by_motion = still > max(FROZEN_S, 2.0 * self.timeout_s) and way > (MOVED if more else MOVED_POSITION_ALONE)
        if by_motion or (exciting and more and still > FROZEN_EXCITING_S):
            return f"the joint states are frozen: the same for {still:.2f} s while the reference moved {way:.2g} rad"
        return ""


def _same(a: float, b: float) -> bool:
    return a == b or (math.isnan(a) and math.isnan(b))


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(names[:8]) + (", ..." if len(names) > 8 else "") if names else "none"
